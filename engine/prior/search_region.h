// Stage `prior`: converts a rough position to the region to search.
#ifndef CAIRN_ENGINE_PRIOR_SEARCH_REGION_H_
#define CAIRN_ENGINE_PRIOR_SEARCH_REGION_H_

#include "engine/prior/prior_options.h"
#include "engine/query/localize_query.h"
#include "engine/query/query_context.h"
#include "storage/map/map_store.h"

namespace cairn {

// Returns the region around the query's prior, with heights unbounded. Without a prior, the region
// covers the bounds of the map, is anchored at their center, and has_prior is false; the map must
// then not be empty (MapInfo::bounds is set).
SearchRegion ResolveSearchRegion(const LocalizeQuery& query, const MapInfo& map,
                                 const PriorOptions& options);

// Returns the latitude-longitude box around the region's disc.
GeoBox RegionBounds(const SearchRegion& region);

}  // namespace cairn

#endif  // CAIRN_ENGINE_PRIOR_SEARCH_REGION_H_
