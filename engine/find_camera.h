// Finds the camera of a query whose focal length is uncertain.
#ifndef CAIRN_ENGINE_FIND_CAMERA_H_
#define CAIRN_ENGINE_FIND_CAMERA_H_

#include <vector>

#include "engine/localizer_options.h"
#include "engine/pose/pose_hypotheses.h"
#include "engine/query/localize_query.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

// Tries several focal lengths (FocalSearch), voting and estimating poses with each. If no pose is
// good, tries them again with the stage `refinement`, as a known camera would be. Returns the
// query's context with the camera of the best pose. `stated` is the context with the camera that
// the query states.
QueryContext FindCamera(const QueryContext& stated, const LocalizeQuery& query,
                        const std::vector<TileView>& tiles, const SharedMatches& matches,
                        const LocalizerOptions& options, const QueryBudget& budget,
                        StageCounters* counters);

}  // namespace cairn

#endif  // CAIRN_ENGINE_FIND_CAMERA_H_
