#include "engine/find_candidates.h"

#include "engine/refinement/keyframe_candidates.h"
#include "engine/voting/pose_voting.h"

namespace cairn {

std::vector<PoseCandidate> FindCandidates(const QueryContext& query,
                                          const std::vector<TileView>& tiles,
                                          const std::vector<Correspondence>& matches,
                                          const LocalizerOptions& options,
                                          const QueryBudget& budget, StageCounters* counters) {
  std::vector<PoseCandidate> candidates;
  if (options.voting.filter == OutlierFilter::kOther) {
    candidates = options.voting.other_filter(tiles, matches, options.voting, counters);
  } else if (query.level_from_cam) {
    candidates = VoteForPoses(query, matches, options.voting, counters, budget.workers,
                              [&budget] { return budget.DeadlinePassed(); });
  } else {
    candidates = KeyframeCandidates(query, tiles, matches, options.refinement);
  }
  counters->num_candidates = static_cast<int64_t>(candidates.size());
  return candidates;
}

}  // namespace cairn
