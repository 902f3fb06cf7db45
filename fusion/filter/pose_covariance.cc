#include "fusion/filter/pose_covariance.h"

namespace cairn::fusion {

Matrix6d RotationFirst() {
  Matrix6d order = Matrix6d::Zero();
  order(0, 4) = order(1, 5) = order(2, 3) = 1.0;
  order.bottomLeftCorner<3, 3>().setIdentity();
  return order;
}

Matrix6x12d GlobalPoseJacobian(const Rigid3d& global_from_local, const Rigid3d& local_from_imu) {
  // R_GI = R_GL Exp(phi) Exp(theta) R_LI and p_GI = R_GL (Exp(phi) p + rho) + p_GL.
  const Eigen::Matrix3d rotation = global_from_local.rotation.toRotationMatrix();
  Matrix6d by_global = Matrix6d::Zero();  // Derivative by [phi, rho].
  by_global.topLeftCorner<3, 3>() = rotation;
  by_global.bottomLeftCorner<3, 3>() = -rotation * Skew(local_from_imu.translation);
  by_global.bottomRightCorner<3, 3>() = rotation;
  Matrix6x12d jacobian = Matrix6x12d::Zero();
  jacobian.topLeftCorner<3, 3>() = rotation;
  jacobian.block<3, 3>(3, 3) = rotation;
  jacobian.rightCols<6>() = by_global * RotationFirst();
  return jacobian;
}

PosePrior CameraPrior(const FilterState& state, int clone) {
  const Rigid3d& local_from_imu = state.clones()[static_cast<size_t>(clone)].local_from_imu;
  const Rigid3d global_from_imu = *state.global_from_local() * local_from_imu;
  const Rigid3d imu_from_cam = state.rig().cam_from_imu.Inverse();
  const int offset = state.CloneIdx(clone);
  const auto covariance = state.covariance();
  Eigen::Matrix<double, 12, 12> joint;
  joint << covariance.block<6, 6>(offset, offset), covariance.block<6, 6>(offset, kGlobalIdx),
      covariance.block<6, 6>(kGlobalIdx, offset), covariance.block<6, 6>(kGlobalIdx, kGlobalIdx);
  // A turn of the IMU moves the camera.
  Matrix6d by_imu = Matrix6d::Identity();
  by_imu.bottomLeftCorner<3, 3>() = -Skew(global_from_imu.rotation * imu_from_cam.translation);
  const Matrix6x12d jacobian =
      by_imu * GlobalPoseJacobian(*state.global_from_local(), local_from_imu);
  return {global_from_imu * imu_from_cam, jacobian * joint * jacobian.transpose()};
}

}  // namespace cairn::fusion
