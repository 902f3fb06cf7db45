// Stage `pose`: estimates a pose for each candidate.
#ifndef CAIRN_ENGINE_POSE_ESTIMATE_CANDIDATE_POSES_H_
#define CAIRN_ENGINE_POSE_ESTIMATE_CANDIDATE_POSES_H_

#include <cstdint>
#include <vector>

#include "engine/pose/pose_hypotheses.h"
#include "engine/pose/pose_options.h"

namespace cairn {

// What the stage uses of the localizer's options, which must outlive the object.
struct CandidatePoseOptions {
  const PoseOptions& pose;
  // Once a pose has at least this evidence, the other candidates need not find it again: only
  // rivals matter. They are sought among the matches that the sure pose does not explain, and only
  // if these are enough keypoints for a share of its consensus (kMinShareOfBest). Infinity spares
  // no candidate.
  double sure_evidence;
  uint64_t seed;
};

// Estimates a pose (EstimatePose) from the matches of each candidate, best candidate first, until
// the deadline. Adds the poses to `hypotheses`.
TriedPoses EstimateCandidatePoses(const QueryContext& query, const SharedMatches& matches,
                                  const std::vector<PoseCandidate>& candidates,
                                  const CandidatePoseOptions& options, const QueryBudget& budget,
                                  PoseHypotheses hypotheses);

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_ESTIMATE_CANDIDATE_POSES_H_
