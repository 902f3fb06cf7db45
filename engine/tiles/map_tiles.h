// The tiles of a map, as queries read them.
#ifndef CAIRN_ENGINE_TILES_MAP_TILES_H_
#define CAIRN_ENGINE_TILES_MAP_TILES_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "core/geodesy.h"
#include "core/large_vector.h"
#include "storage/codebook/codebook.h"
#include "storage/map/map_store.h"
#include "storage/map/session_accuracy.h"
#include "storage/tile/decoded_tile.h"

namespace cairn {

struct StoredTile {
  LargeVector<uint8_t> payload;  // As EncodeTile returns it; empty if the tile is `decoded`.
  std::shared_ptr<const DecodedTile> decoded;  // What the payload holds, if it is at hand.
  std::optional<SessionAccuracy> accuracy;     // Of the tile's sessions; empty if unknown.
};

// One version of a map, on disk or in memory. Safe to call from any thread.
class MapTiles {
 public:
  virtual ~MapTiles() = default;

  // Returns the codebook of all tiles that can be searched, or null if the map is empty.
  virtual std::shared_ptr<const Codebook> CurrentCodebook() const = 0;
  // Returns the tiles whose square's bounding box intersects `box`, and perhaps others, ordered by
  // tile id. Of a record, at least tile_id, digest, codebook_id and the heights are set. Different
  // payloads have different digests.
  virtual std::vector<TileRecord> FindTiles(const GeoBox& box) const = 0;
  // Loads a tile that FindTiles returned. Throws Error(kMapDamaged) if its payload is missing.
  virtual StoredTile LoadTile(const TileRecord& record) const = 0;
};

// Returns the accuracy of sessions together; empty if the map does not know it.
std::optional<SessionAccuracy> AccuracyOf(const std::set<SessionId>& sessions,
                                          const MapSnapshot& map);

// A version of a map on disk. Throws as the calls of MapSnapshot.
class SnapshotTiles : public MapTiles {
 public:
  // `snapshot` must outlive the object.
  explicit SnapshotTiles(const MapSnapshot& snapshot) : snapshot_(snapshot) {}

  std::shared_ptr<const Codebook> CurrentCodebook() const override {
    return snapshot_.CurrentCodebook();
  }
  std::vector<TileRecord> FindTiles(const GeoBox& box) const override {
    return snapshot_.FindTiles(box);
  }
  StoredTile LoadTile(const TileRecord& record) const override;

 private:
  const MapSnapshot& snapshot_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_MAP_TILES_H_
