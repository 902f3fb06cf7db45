// What the prior says about a pose that was found.
#ifndef CAIRN_ENGINE_PRIOR_POSE_SHARE_H_
#define CAIRN_ENGINE_PRIOR_POSE_SHARE_H_

#include <Eigen/Core>

#include "engine/query/query_context.h"

namespace cairn {

// Logarithm of the prior probability that the pose is the one at `center_in_anchor`: the inverse of
// the number of poses that can be told apart, which is what evidence against chance has to make up
// for. Poses are told apart by 1 m in each direction and 2 degrees about each axis; heights reach
// over 5 m, tilts (unless gravity is used) over 60 degrees each. Positions follow a bivariate
// Student distribution with three degrees of freedom about the prior: receivers are sometimes
// wrong by far more than they say. Without a prior they are anywhere in the region alike.
double LogPoseShare(const SearchRegion& region, const Eigen::Vector3d& center_in_anchor,
                    bool used_gravity);

// The place that the prior names, or the middle of the region.
Eigen::Vector3d PriorCenter(const SearchRegion& region);

// True if there is a prior and the position is farther from it than three of its standard
// deviations, where one in a hundred is.
bool DisagreesWithPrior(const SearchRegion& region, const Eigen::Vector3d& center_in_anchor);

}  // namespace cairn

#endif  // CAIRN_ENGINE_PRIOR_POSE_SHARE_H_
