// Stage `voting`: finds places where the camera may be, each with the matches that support it.
#ifndef CAIRN_ENGINE_FIND_CANDIDATES_H_
#define CAIRN_ENGINE_FIND_CANDIDATES_H_

#include <vector>

#include "engine/localizer_options.h"
#include "engine/query/localize_result.h"
#include "engine/query/pose_candidate.h"
#include "engine/query/query_budget.h"
#include "engine/query/query_context.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

// Runs the filter that the options select. Voting needs gravity, so a query without gravity gets
// its candidates from the best ranked keyframes.
std::vector<PoseCandidate> FindCandidates(const QueryContext& query,
                                          const std::vector<TileView>& tiles,
                                          const std::vector<Correspondence>& matches,
                                          const LocalizerOptions& options,
                                          const QueryBudget& budget, StageCounters* counters);

}  // namespace cairn

#endif  // CAIRN_ENGINE_FIND_CANDIDATES_H_
