// Stage `tiles`: gets the tiles near the region, through the cache.
#ifndef CAIRN_ENGINE_TILES_FETCH_TILES_H_
#define CAIRN_ENGINE_TILES_FETCH_TILES_H_

#include <vector>

#include "core/stop_function.h"
#include "engine/index/index_options.h"
#include "engine/query/localize_result.h"
#include "engine/query/query_context.h"
#include "engine/tiles/searchable_tile.h"
#include "engine/tiles/tile_cache.h"
#include "engine/tiles/tiles_options.h"
#include "storage/map/map_store.h"

namespace cairn {

// Returns the tiles whose square intersects the region's disc, nearest first, at most
// options.max_tiles. Loads missing tiles (fetch, decode, index) into the cache, several in
// parallel. The cache must hold only tiles of this map that were made with the same index_options.
//
// Intersects the region's heights with the range of the tiles' keyframe heights, widened by the
// margin. A height prior entirely outside that range is dropped: a wrong datum is a likelier cause
// than a camera where no camera ever was.
//
// Polls `should_stop`. Once it returns true, tiles that are not in the cache are left out, except
// the nearest, and missing parts of indices stay missing (MatchingIndex::is_complete). The other
// data that matching needs is then decoded by the first thread that requests it. Without
// `should_stop`, all of this is complete on return: each part is built once, by this call or by a
// concurrent one.
//
// Sets the tile counters and num_descriptors. Throws Error(kMapDamaged) if a payload does not
// decode or belongs to another tile than its record, and what MapSnapshot throws.
std::vector<TileView> FetchTiles(const MapSnapshot& snapshot, TileCache* cache,
                                 const TilesOptions& options, const IndexOptions& index_options,
                                 SearchRegion* region, StageCounters* counters,
                                 const StopFunction& should_stop = {});

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_FETCH_TILES_H_
