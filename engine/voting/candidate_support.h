// Which correspondences agree with a pose candidate, and where they would have it.
#ifndef CAIRN_ENGINE_VOTING_CANDIDATE_SUPPORT_H_
#define CAIRN_ENGINE_VOTING_CANDIDATE_SUPPORT_H_

#include <Eigen/Core>

#include "engine/query/pose_candidate.h"
#include "engine/voting/ray_arrays.h"
#include "engine/voting/voting_options.h"

namespace cairn {

// Tests each ray against the camera at `center_in_anchor` with `yaw_rad`: the landmark must lie
// within the ray's distances (one cell of slack), its azimuth must fit, and the angle e between ray
// and landmark must be below t = direction_tolerance_rad + cell_xy_m / distance. A keypoint scores
// the best 1 - (e / t)^2 of its rays; the candidate's score is the sum. With
// OutlierFilter::kVoting3d only horizontal components are compared, as the height is unknown.
// Centre and yaw are those given.
PoseCandidate SupportedCandidate(const RayArrays<double>& rays,
                                 const Eigen::Vector3d& center_in_anchor, double yaw_rad,
                                 const VotingOptions& options);

// Starts at a pose that is known to a cell and moves it to where the rays that agree meet, twice,
// with tolerances that narrow (docs/math/localization.md, section "Votes"). The score is by the
// narrowed tolerances at the pose found, which is returned too; the correspondences are those that
// agree with it as in SupportedCandidate, so that few right ones are missed. Compares in 3D space,
// whatever the filter.
PoseCandidate SettledCandidate(const RayArrays<double>& rays,
                               const Eigen::Vector3d& center_in_anchor, double yaw_rad,
                               const VotingOptions& options);

}  // namespace cairn

#endif  // CAIRN_ENGINE_VOTING_CANDIDATE_SUPPORT_H_
