#include "engine/pose/estimate_candidate_poses.h"

#include <vector>

#include "engine/pose/estimate_pose.h"

namespace cairn {

namespace {

// Returns the pose with the most evidence if that is at least `sure_evidence`, else null.
const PoseEstimate* SurePose(const PoseHypotheses& hypotheses, double sure_evidence) {
  if (!hypotheses.AnyHasEvidence(sure_evidence)) {
    return nullptr;
  }
  return &hypotheses.Best(1).front()->estimate;
}

}  // namespace

bool EstimateCandidatePoses(const QueryContext& query, const SharedMatches& matches,
                            const std::vector<PoseCandidate>& candidates,
                            const PoseOptions& options, double sure_evidence, uint64_t seed,
                            const QueryBudget& budget, PoseHypotheses* hypotheses,
                            StageCounters* counters) {
  const auto num_candidates = static_cast<int>(candidates.size());
  const auto attempt = [&](int i, double min_consensus) -> PoseAttempt {
    const std::vector<int>& subset = candidates[i].correspondences;
    const PoseEstimate* sure = SurePose(*hypotheses, sure_evidence);
    return {matches, EstimatePose(query, *matches,
                                  sure == nullptr ? subset
                                                  : Unexplained(query, *matches, subset,
                                                                sure->cam_from_anchor, options),
                                  options, seed, min_consensus)};
  };
  const int num_tried = hypotheses->TryInRounds(num_candidates, query.down_in_cam.has_value(),
                                                budget, attempt, counters);
  const bool is_complete = num_tried == num_candidates;
  counters->pose_cut_short |= !is_complete;
  return is_complete;
}

}  // namespace cairn
