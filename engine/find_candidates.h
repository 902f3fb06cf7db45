// Stage `voting`: finds places where the camera may be, each with the matches that support it.
#ifndef CAIRN_ENGINE_FIND_CANDIDATES_H_
#define CAIRN_ENGINE_FIND_CANDIDATES_H_

#include "engine/localizer_options.h"
#include "engine/query/query_budget.h"
#include "engine/refinement/match_keyframes.h"
#include "engine/voting/pose_voting.h"

namespace cairn {

// Runs the filter that the options select. Voting needs gravity, so a query without gravity gets
// its candidates from the best ranked keyframes, without votes.
VotedPoses FindCandidates(const MatchedQuery& matched, const LocalizerOptions& options,
                          const QueryBudget& budget);

}  // namespace cairn

#endif  // CAIRN_ENGINE_FIND_CANDIDATES_H_
