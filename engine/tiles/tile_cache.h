// The searchable tiles in memory, by the digests of their payloads.
#ifndef CAIRN_ENGINE_TILES_TILE_CACHE_H_
#define CAIRN_ENGINE_TILES_TILE_CACHE_H_

#include <cstddef>

#include "core/loading_cache.h"
#include "engine/index/index_options.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

inline constexpr size_t kDefaultCacheBytes = size_t{1} << 30;

// Tiles of old map versions age out.
class TileCache : public LoadingCache<SearchableTile> {
 public:
  // Throws Error(kInvalidArgument) if `max_bytes` is 0.
  explicit TileCache(size_t max_bytes, const IndexOptions& index_options = {})
      : LoadingCache(max_bytes), index_options_(index_options) {}

  // How all tiles of the cache are indexed.
  const IndexOptions& index_options() const { return index_options_; }
  // Returns true if these options make the same indices.
  bool IndexesAs(const IndexOptions& options) const;

 private:
  const IndexOptions index_options_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_TILE_CACHE_H_
