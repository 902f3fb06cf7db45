#include "engine/pose/estimate_candidate_poses.h"

#include "engine/pose/estimate_pose.h"

namespace cairn {

void EstimateCandidatePoses(const QueryContext& query, const SharedMatches& matches,
                            const std::vector<PoseCandidate>& candidates,
                            const PoseOptions& options, uint64_t seed, const QueryBudget& budget,
                            PoseHypotheses* hypotheses, StageCounters* counters) {
  const auto num_candidates = static_cast<int>(candidates.size());
  const auto attempt = [&](int i, double min_consensus) -> PoseAttempt {
    return {matches, EstimatePose(query, *matches, candidates[i].correspondences, options, seed,
                                  min_consensus)};
  };
  const int num_tried = hypotheses->TryInRounds(num_candidates, query.down_in_cam.has_value(),
                                                budget, attempt, counters);
  counters->pose_cut_short |= num_tried < num_candidates;
}

}  // namespace cairn
