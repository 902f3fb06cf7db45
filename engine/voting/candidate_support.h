// Finds the correspondences that agree with a pose candidate, and moves the candidate to fit them.
#ifndef CAIRN_ENGINE_VOTING_CANDIDATE_SUPPORT_H_
#define CAIRN_ENGINE_VOTING_CANDIDATE_SUPPORT_H_

#include <Eigen/Core>

#include "engine/query/pose_candidate.h"
#include "engine/voting/ray_arrays.h"
#include "engine/voting/voting_options.h"

namespace cairn {

// Tests each ray against the camera at `center_in_anchor` with `yaw_rad`. A ray agrees if the
// landmark lies within the ray's distances (with one cell of slack), its azimuth fits, and the
// angle e between ray and landmark is below t = direction_tolerance_rad + cell_xy_m / distance. A
// keypoint scores the best 1 - (e / t)^2 of its rays; the candidate's score is the sum over the
// keypoints. With OutlierFilter::kVoting3d, the height is unknown, so only horizontal components
// are compared. The candidate has the given center and yaw.
PoseCandidate SupportedCandidate(const RayArrays<double>& rays,
                                 const Eigen::Vector3d& center_in_anchor, double yaw_rad,
                                 const VotingOptions& options);

// Moves a pose that is known to within a cell toward the point where the agreeing rays meet, in
// two steps with narrowing tolerances (docs/math/localization.md, section "Votes"). Returns the
// candidate at the final pose. Its score uses the narrowed tolerances. Its correspondences are
// those that agree with the final pose by the tolerances of SupportedCandidate, so that few right
// ones are missed. Compares in 3-D space for every filter.
PoseCandidate SettledCandidate(const RayArrays<double>& rays,
                               const Eigen::Vector3d& center_in_anchor, double yaw_rad,
                               const VotingOptions& options);

}  // namespace cairn

#endif  // CAIRN_ENGINE_VOTING_CANDIDATE_SUPPORT_H_
