// Covariances of composed poses.
#ifndef CAIRN_FUSION_CLIENT_POSE_COVARIANCE_H_
#define CAIRN_FUSION_CLIENT_POSE_COVARIANCE_H_

#include <Eigen/Core>

#include "fusion/client/fusion_types.h"
#include "fusion/filter/filter_state.h"

namespace cairn::fusion {

using Matrix6x12d = Eigen::Matrix<double, 6, 12>;

// Derivative of the error of global_from_imu by the errors [theta, p] of local_from_imu and [rho,
// psi, tilt] of global_from_local. The error of global_from_imu is [rotation, translation] on the
// left, in global.
Matrix6x12d GlobalPoseJacobian(const Rigid3d& global_from_local, const Rigid3d& local_from_imu);

// Returns the matrix that reorders an error [rho, psi, tilt] of global_from_local to [rotation,
// translation].
Matrix6d RotationFirst();

// Returns the camera's pose in global at a clone, with its covariance. `state` must be aligned.
PosePrior CameraPrior(const FilterState& state, int clone);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_CLIENT_POSE_COVARIANCE_H_
