// The searchable tiles in memory, by the digests of their payloads.
#ifndef CAIRN_ENGINE_TILES_TILE_CACHE_H_
#define CAIRN_ENGINE_TILES_TILE_CACHE_H_

#include <cstddef>

#include "core/loading_cache.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

// Tiles of old map versions age out. All tiles of a cache are indexed with the same IndexOptions.
using TileCache = LoadingCache<SearchableTile>;

inline constexpr size_t kDefaultCacheBytes = size_t{1} << 30;

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_TILE_CACHE_H_
