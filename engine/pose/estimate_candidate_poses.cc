#include "engine/pose/estimate_candidate_poses.h"

#include <utility>
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

TriedPoses EstimateCandidatePoses(const QueryContext& query, const SharedMatches& matches,
                                  const std::vector<PoseCandidate>& candidates,
                                  const CandidatePoseOptions& options, const QueryBudget& budget,
                                  PoseHypotheses hypotheses) {
  const auto num_candidates = static_cast<int>(candidates.size());
  const auto attempt = [&](int i, double min_consensus) -> PoseAttempt {
    const std::vector<int>& subset = candidates[i].correspondences;
    const PoseEstimate* sure = SurePose(hypotheses, options.sure_evidence);
    return {matches,
            EstimatePose(query, *matches,
                         sure == nullptr ? subset
                                         : Unexplained(query, *matches, subset,
                                                       sure->cam_from_anchor, options.pose),
                         options.pose, options.seed, min_consensus)};
  };
  const AttemptCount count =
      hypotheses.TryInRounds(num_candidates, query.down_in_cam.has_value(), budget, attempt);
  return {std::move(hypotheses), count, count.num_made == num_candidates};
}

}  // namespace cairn
