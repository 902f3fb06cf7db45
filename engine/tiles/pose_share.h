// The share of the prior in the evidence of a found pose.
#ifndef CAIRN_ENGINE_TILES_POSE_SHARE_H_
#define CAIRN_ENGINE_TILES_POSE_SHARE_H_

#include <Eigen/Core>

#include "engine/query/pose_candidate.h"
#include "engine/query/query_context.h"

namespace cairn {

// Returns the logarithm of the prior probability that the camera's pose is one of those that
// explain the inliers of `estimate` about as well as its own pose (PoseEstimate::log_volume), if
// the camera is at `center_in_anchor`. The inverse of that probability is the number of poses that
// the inliers distinguish, for which the evidence against chance must compensate: evidence plus
// this logarithm is Laplace's approximation of the likelihood ratio of all poses together. At most
// 0.
//
// Heights range over 5 m and headings over the full circle. Tilts have the density that gravity
// gives (PoseEstimate::log_tilt_density). Positions follow a bivariate Student distribution with
// three degrees of freedom around the prior, because receivers are sometimes wrong by far more than
// they report. Without a prior, positions are uniform over
// SearchRegion::area_m2.
double LogPoseShare(const SearchRegion& region, const Eigen::Vector3d& center_in_anchor,
                    const PoseEstimate& estimate);

// Returns the prior's position, or the center of the region if there is no prior.
Eigen::Vector3d PriorCenter(const SearchRegion& region);

// Returns true if there is a prior and the position is more than three of its standard deviations
// away, as 1 % of positions are.
bool DisagreesWithPrior(const SearchRegion& region, const Eigen::Vector3d& center_in_anchor);

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_POSE_SHARE_H_
