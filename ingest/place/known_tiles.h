// What a map knows without the session that an ingest replaces. Private to ingest.
#ifndef CAIRN_INGEST_PLACE_KNOWN_TILES_H_
#define CAIRN_INGEST_PLACE_KNOWN_TILES_H_

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "engine/tiles/map_tiles.h"
#include "ingest/place/tile_memory.h"
#include "storage/ids.h"
#include "storage/map/map_store.h"
#include "storage/tile/tile.h"

namespace cairn {

// The tiles of a map without one session, for the engine and for the ingest. Safe to call from any
// thread. Calls throw as those of RememberedTiles.
class KnownTiles : public MapTiles {
 public:
  // `without` is 0 if no session is replaced. `map` must outlive the object.
  explicit KnownTiles(const MapSnapshot& map, SessionId without = SessionId{},
                      std::shared_ptr<TileMemory> memory = std::make_shared<TileMemory>());

  // The tiles with the session.
  const RememberedTiles& stored() const { return stored_; }
  const std::shared_ptr<TileMemory>& memory() const { return stored_.memory(); }
  // Returns the tile, which may be empty, or null if the map has none.
  std::shared_ptr<const Tile> Find(TileId tile_id) const;

  std::shared_ptr<const Codebook> CurrentCodebook() const override {
    return stored_.CurrentCodebook();
  }
  std::vector<TileRecord> FindTiles(const GeoBox& box) const override;
  StoredTile LoadTile(const TileRecord& record) const override;

 private:
  // A tile that holds the session.
  struct Changed {
    TileRecord stored;
    std::optional<TileRecord> record;  // Without the session; empty if nothing is left.
  };

  std::shared_ptr<const DecodedTile> WithoutIt(const TileRecord& stored) const;

  const RememberedTiles stored_;
  const SessionId without_;
  std::map<TileId, Changed> changed_;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_KNOWN_TILES_H_
