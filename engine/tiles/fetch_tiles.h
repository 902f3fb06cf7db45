// Stage `tiles`: the map near the region, through the cache.
#ifndef CAIRN_ENGINE_TILES_FETCH_TILES_H_
#define CAIRN_ENGINE_TILES_FETCH_TILES_H_

#include <vector>

#include "core/stop_function.h"
#include "engine/index/index_options.h"
#include "engine/query/localize_result.h"
#include "engine/query/query_context.h"
#include "engine/tiles/searchable_tile.h"
#include "engine/tiles/tiles_options.h"
#include "storage/map/map_store.h"
#include "storage/map/tile_cache.h"

namespace cairn {

// With a prior: the tiles whose square meets the region's disc, nearest first. Without: the first
// of the map by tile id. At most options.max_tiles. Loads what the cache misses (fetch, decode,
// index), several tiles in parallel; the cache must hold nothing but tiles of this map made with
// these index_options.
//
// Intersects the region's heights with those of the tiles' keyframes, widened by the margin. A
// height prior that lies wholly outside them is dropped: it is more often a wrong datum than a
// camera where none ever was.
//
// When `should_stop` says so, tiles that are not in the cache are left out, all but the nearest,
// parts that are missing of an index stay so (MatchingIndex::is_complete), and what matching needs
// beside it is decoded by whoever asks first. Without it all of that is there: made by this call or
// by others at the same time, each part once.
//
// Sets the tile counters and num_descriptors. Throws Error(kMapDamaged) if a payload does not
// decode or is not the tile its record says.
std::vector<TileView> FetchTiles(const MapSnapshot& snapshot, TileCache* cache,
                                 const TilesOptions& options, const IndexOptions& index_options,
                                 SearchRegion* region, StageCounters* counters,
                                 const StopFunction& should_stop = {});

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_FETCH_TILES_H_
