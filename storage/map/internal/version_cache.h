// Caches content of one version; private to storage.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_VERSION_CACHE_H_
#define CAIRN_STORAGE_MAP_INTERNAL_VERSION_CACHE_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

#include "storage/map/map_store.h"

namespace cairn {

// A tile with its bounding box, which takes microseconds to compute.
struct BoundedTile {
  TileRecord record;
  GeoBox bounds;
};

// Null if the version has no such tile.
using FoundTile = std::shared_ptr<const BoundedTile>;

struct FoundTiles {
  std::vector<FoundTile> tiles;      // Not null.
  std::vector<int64_t> missing_ids;  // Nobody knows yet whether there is such a tile.
};

// The content of a version never changes, so nothing here is ever wrong. Safe to call from any
// thread.
class VersionCache {
 public:
  static constexpr size_t kMaxTiles = 262'144;  // 0.3 kB each; squares without a tile take less.

  explicit VersionCache(MapVersion version) : version_(version) {}

  MapVersion version() const { return version_; }

  // Returns the codebook of the version (0 if the version has none), or nothing if it is not
  // cached.
  std::optional<CodebookId> codebook_id() const;
  void KeepCodebook(CodebookId codebook_id);

  FoundTiles Find(const std::vector<int64_t>& tile_ids) const;
  // Once there are many tiles, drops all others.
  void Keep(const std::unordered_map<int64_t, FoundTile>& tiles);

 private:
  const MapVersion version_;
  mutable std::mutex mutex_;
  std::optional<CodebookId> codebook_id_;
  std::unordered_map<int64_t, FoundTile> tiles_;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_INTERNAL_VERSION_CACHE_H_
