// The part of a map in which a photo can be searched without a position. Private to ingest.
#ifndef CAIRN_INGEST_PLACE_TILES_AROUND_H_
#define CAIRN_INGEST_PLACE_TILES_AROUND_H_

#include <memory>
#include <optional>
#include <vector>

#include "core/geodesy.h"
#include "engine/tiles/map_tiles.h"
#include "storage/ids.h"

namespace cairn {

// At most 400 tiles of a map within a radius of one of some places, the nearest to one of them.
// Calls throw as those of the map. Safe to call from any thread.
class TilesAround : public MapTiles {
 public:
  // `map` must outlive the object.
  TilesAround(const MapTiles& map, const std::vector<Geodetic>& places, double radius_m);

  bool empty() const { return tiles_.empty(); }

  std::shared_ptr<const Codebook> CurrentCodebook() const override {
    return map_.CurrentCodebook();
  }
  std::vector<TileRecord> FindTiles(const GeoBox& box) const override;
  StoredTile LoadTile(const TileRecord& record) const override { return map_.LoadTile(record); }

 private:
  const MapTiles& map_;
  std::vector<TileRecord> tiles_;  // Ordered by id.
};

// Returns the distance from the nearest of the places to the nearest tile: its middle, and half of
// its side less. Empty if there are no places or the map has no tiles.
std::optional<double> DistanceToMapM(const MapTiles& map, const std::vector<Geodetic>& places);

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_TILES_AROUND_H_
