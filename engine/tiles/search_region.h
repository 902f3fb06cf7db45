// Stage `prior`: converts a rough position to the region to search.
#ifndef CAIRN_ENGINE_TILES_SEARCH_REGION_H_
#define CAIRN_ENGINE_TILES_SEARCH_REGION_H_

#include <cstdint>

#include "engine/query/localize_query.h"
#include "engine/query/query_context.h"
#include "engine/tiles/prior_options.h"

namespace cairn {

// Returns the region around the prior of a query, with heights unbounded.
SearchRegion RegionOfPrior(const PositionPrior& prior, const PriorOptions& options);

// Returns the region around a place of a map with `num_tiles` tiles, with heights unbounded. The
// camera may be in any of the tiles.
SearchRegion RegionOfPlace(const Geodetic& center, double radius_m, int64_t num_tiles);

// Returns the latitude-longitude box around the region's disc.
GeoBox RegionBounds(const SearchRegion& region);

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_SEARCH_REGION_H_
