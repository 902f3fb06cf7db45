// The share of the prior in the evidence of a found pose.
#ifndef CAIRN_ENGINE_PRIOR_POSE_SHARE_H_
#define CAIRN_ENGINE_PRIOR_POSE_SHARE_H_

#include <Eigen/Core>

#include "engine/query/query_context.h"

namespace cairn {

// Returns the logarithm of the prior probability that the camera's pose is the one at
// `center_in_anchor`. That probability is the inverse of the number of distinguishable poses, for
// which the evidence against chance must compensate. Poses are distinguishable if they differ by 1
// m in a direction or by 2 degrees about an axis. Heights range over 5 m; tilts range over 60
// degrees each, unless gravity is used. Positions follow a bivariate Student distribution with
// three degrees of freedom around the prior, because receivers are sometimes wrong by far more than
// they report. Without a prior, positions are uniform over the region.
double LogPoseShare(const SearchRegion& region, const Eigen::Vector3d& center_in_anchor,
                    bool used_gravity);

// Returns the prior's position, or the center of the region if there is no prior.
Eigen::Vector3d PriorCenter(const SearchRegion& region);

// Returns true if there is a prior and the position is more than three of its standard deviations
// away, as 1 % of positions are.
bool DisagreesWithPrior(const SearchRegion& region, const Eigen::Vector3d& center_in_anchor);

}  // namespace cairn

#endif  // CAIRN_ENGINE_PRIOR_POSE_SHARE_H_
