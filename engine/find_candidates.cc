#include "engine/find_candidates.h"

#include "engine/refinement/keyframe_candidates.h"

namespace cairn {

VotedPoses FindCandidates(const MatchedQuery& matched, const LocalizerOptions& options,
                          const QueryBudget& budget) {
  const auto& [query, tiles, matches] = matched;
  if (options.voting.filter == OutlierFilter::kOther) {
    return {options.voting.other_filter(tiles, *matches, options.voting), 0};
  }
  if (query.level_from_cam) {
    return VoteForPoses(query, *matches, options.voting, budget.workers,
                        [&budget] { return budget.DeadlinePassed(); });
  }
  return {KeyframeCandidates(query, tiles, *matches, options.refinement), 0};
}

}  // namespace cairn
