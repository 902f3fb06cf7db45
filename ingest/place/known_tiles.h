// What a map knows without the session that an ingest replaces. Private to ingest.
#ifndef CAIRN_INGEST_PLACE_KNOWN_TILES_H_
#define CAIRN_INGEST_PLACE_KNOWN_TILES_H_

#include <cstddef>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "core/loading_cache.h"
#include "engine/tiles/map_tiles.h"
#include "storage/ids.h"
#include "storage/map/map_store.h"
#include "storage/tile/tile.h"

namespace cairn {

// The tiles of a map without one session, for the engine and for the ingest. Decodes each tile
// once, as long as the tiles fit into memory. Safe to call from any thread. Calls throw as those of
// MapSnapshot, and Error(kMapDamaged) if a tile does not decode.
class KnownTiles : public MapTiles {
 public:
  // `without` is 0 if no session is replaced. `map` must outlive the object.
  explicit KnownTiles(const MapSnapshot& map, SessionId without = SessionId{});

  const MapSnapshot& map() const { return map_; }
  // Returns the tile, which may be empty, or null if the map has none.
  std::shared_ptr<const Tile> Find(TileId tile_id) const;

  std::shared_ptr<const Codebook> CurrentCodebook() const override {
    return map_.CurrentCodebook();
  }
  std::vector<TileRecord> FindTiles(const GeoBox& box) const override;
  StoredTile LoadTile(const TileRecord& record) const override;

 private:
  struct Known {
    Tile tile;
    std::optional<TileRecord> record;  // Of a changed tile that is not empty.

    size_t MemoryBytes() const { return tile.MemoryBytes(); }
  };

  std::shared_ptr<const Known> Decoded(const TileRecord& stored) const;
  bool HasChanged(TileId tile_id) const { return changed_.contains(tile_id); }

  const MapSnapshot& map_;
  const SnapshotTiles stored_;
  const SessionId without_;
  std::set<TileId> changed_;  // The tiles that hold the session.
  mutable LoadingCache<Known> decoded_;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_KNOWN_TILES_H_
