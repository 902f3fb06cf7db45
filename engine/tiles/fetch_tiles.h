// Stage `tiles`: gets the tiles near the region, through the cache.
#ifndef CAIRN_ENGINE_TILES_FETCH_TILES_H_
#define CAIRN_ENGINE_TILES_FETCH_TILES_H_

#include <cstdint>
#include <vector>

#include "core/stop_function.h"
#include "engine/query/query_context.h"
#include "engine/tiles/map_tiles.h"
#include "engine/tiles/searchable_tile.h"
#include "engine/tiles/tile_cache.h"
#include "engine/tiles/tiles_options.h"

namespace cairn {

struct FetchedTiles {
  std::vector<TileView> views;  // Nearest first.
  // The region asked for, with its heights intersected with the range of the tiles' keyframe
  // heights, widened by the margin. A height prior entirely outside that range is dropped: a wrong
  // datum is a likelier cause than a camera where no camera ever was.
  SearchRegion region;
  int64_t num_found = 0;        // Tiles that meet the region.
  bool limit_hit = false;       // More than options.max_tiles were found.
  bool is_complete = true;      // `should_stop` left out no tile and no part of an index.
  int64_t num_loaded = 0;       // Cache misses.
  int64_t num_descriptors = 0;  // In `views`.
};

// Returns the tiles whose square intersects the region's disc, at most options.max_tiles. Loads
// missing tiles (fetch, decode, index) into the cache, one on each core at a time, whatever
// LocalizerOptions::num_threads says: threads of their own cost 30 us for two tiles, and a tile
// takes 15 ms or more.
//
// Polls `should_stop`. Once it returns true, tiles that are not in the cache are left out, except
// the nearest, and missing parts of indices stay missing (MatchingIndex::is_complete). The other
// data that matching needs is then decoded by the first thread that requests it. Without
// `should_stop`, all of this is complete on return: each part is built once, by this call or by a
// concurrent one.
//
// Throws Error(kMapDamaged) if a payload does not decode or belongs to another tile than its
// record, and what `map` throws.
FetchedTiles FetchTiles(const MapTiles& map, const SearchRegion& region,
                        const TilesOptions& options, TileCache* cache,
                        const StopFunction& should_stop = {});

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_FETCH_TILES_H_
