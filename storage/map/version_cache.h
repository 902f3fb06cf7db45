// Caches content of one version; private to storage.
#ifndef CAIRN_STORAGE_MAP_VERSION_CACHE_H_
#define CAIRN_STORAGE_MAP_VERSION_CACHE_H_

#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "storage/map/map_store.h"
#include "storage/map/tile_cells.h"

namespace cairn {

// A tile with its bounding box, which takes a microsecond to compute.
struct BoundedTile {
  TileRecord record;
  GeoBox bounds;
};

// The tiles of a cell, in any order.
using CellTiles = std::shared_ptr<const std::vector<BoundedTile>>;

// The content of a version never changes, so nothing here is ever wrong. Safe to call from any
// thread.
class VersionCache {
 public:
  explicit VersionCache(MapVersion version) : version_(version) {}

  MapVersion version() const { return version_; }

  // Returns the codebook of the version (0 if the version has none), or nothing if it is not
  // cached.
  std::optional<CodebookId> codebook_id() const;
  void KeepCodebook(CodebookId codebook_id);

  CellTiles Find(TileCell cell) const;  // Null if the cell is not cached.
  // Once there are many cells, drops any other cell.
  void Keep(TileCell cell, CellTiles tiles);

 private:
  const MapVersion version_;
  mutable std::mutex mutex_;
  std::optional<CodebookId> codebook_id_;
  std::unordered_map<TileCell, CellTiles> cells_;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_VERSION_CACHE_H_
