// Covariances of composed poses.
#ifndef CAIRN_FUSION_FILTER_POSE_COVARIANCE_H_
#define CAIRN_FUSION_FILTER_POSE_COVARIANCE_H_

#include <Eigen/Core>

#include "core/rigid3.h"
#include "fusion/filter/filter_state.h"

namespace cairn::fusion {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Matrix6x12d = Eigen::Matrix<double, 6, 12>;

// A pose with the covariance of (rotation, translation), in rad^2, rad m and m^2. The perturbation
// is on the left in the target frame, as in LocalizeResult::covariance.
struct PosePrior {
  Rigid3d global_from_cam;
  Matrix6d covariance;
};

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

#endif  // CAIRN_FUSION_FILTER_POSE_COVARIANCE_H_
