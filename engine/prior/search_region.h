// Stage `prior`: from a rough position to the region that is searched.
#ifndef CAIRN_ENGINE_PRIOR_SEARCH_REGION_H_
#define CAIRN_ENGINE_PRIOR_SEARCH_REGION_H_

#include "engine/prior/prior_options.h"
#include "engine/query/localize_query.h"
#include "engine/query/query_context.h"
#include "storage/map/map_store.h"

namespace cairn {

// The region about the query's prior. Without a prior the region is the bounds of the map, anchored
// at their centre; has_prior is false. Heights are left open. The map must not be empty if there is
// no prior (MapInfo::bounds is set).
SearchRegion ResolveSearchRegion(const LocalizeQuery& query, const MapInfo& map,
                                 const PriorOptions& options);

// The latitude-longitude box of the region's disc.
GeoBox RegionBounds(const SearchRegion& region);

}  // namespace cairn

#endif  // CAIRN_ENGINE_PRIOR_SEARCH_REGION_H_
