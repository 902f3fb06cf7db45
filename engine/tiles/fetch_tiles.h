// Stage `tiles`: the map near the region, through the cache.
#ifndef CAIRN_ENGINE_TILES_FETCH_TILES_H_
#define CAIRN_ENGINE_TILES_FETCH_TILES_H_

#include <vector>

#include "engine/localize_result.h"
#include "engine/matching/matching_options.h"
#include "engine/query_context.h"
#include "engine/tiles/searchable_tile.h"
#include "engine/tiles/tiles_options.h"
#include "storage/map_store.h"
#include "storage/tile_cache.h"

namespace cairn {

// Tiles that meet the region, nearest first, at most options.max_tiles; loads what the cache misses
// (fetch, decode, index). Sets the region's height band and the tile counters.
std::vector<TileView> FetchTiles(const MapSnapshot& snapshot, TileCache* cache,
                                 const TilesOptions& options, const RandomGridsOptions& index_options,
                                 SearchRegion* region, StageCounters* counters);

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_FETCH_TILES_H_
