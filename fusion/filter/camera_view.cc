#include "fusion/filter/camera_view.h"

namespace cairn::fusion {

CameraView::CameraView(const Rig& rig, const Clone& clone)
    : first_position_in_local(clone.first_position_in_local) {
  const Rigid3d local_from_cam = clone.local_from_imu * rig.cam_from_imu.Inverse();
  cam_from_local_rotation = local_from_cam.rotation.conjugate().toRotationMatrix();
  center_in_local = local_from_cam.translation;
}

std::optional<PredictedPixel> PredictPixel(const Camera& camera, const CameraView& view,
                                           const Eigen::Vector3d& x_in_local) {
  constexpr double kMinDepthM = 0.05;
  PredictedPixel predicted;
  predicted.x_in_cam = view.ToCam(x_in_local);
  if (!(predicted.x_in_cam.z() > kMinDepthM)) {
    return std::nullopt;
  }
  const auto pixel = camera.ProjectWithJacobian(predicted.x_in_cam, &predicted.by_cam);
  if (!pixel) {
    return std::nullopt;
  }
  predicted.pixel = *pixel;
  predicted.by_local = predicted.by_cam * view.cam_from_local_rotation;
  return predicted;
}

Eigen::Matrix<double, 2, kCloneDim> ByClone(const PredictedPixel& predicted, const CameraView& view,
                                            const Eigen::Vector3d& x_in_local) {
  Eigen::Matrix<double, 2, kCloneDim> jacobian;
  jacobian << predicted.by_local * Skew(x_in_local - view.first_position_in_local),
      -predicted.by_local;
  return jacobian;
}

Eigen::Matrix<double, 2, kGlobalDim> ByGlobal(const PredictedPixel& predicted,
                                              const Eigen::Vector3d& x_in_local) {
  const Eigen::Matrix<double, 2, 3> by_rotation = predicted.by_local * Skew(x_in_local);
  Eigen::Matrix<double, 2, kGlobalDim> jacobian;
  jacobian << -predicted.by_local, by_rotation.col(2), by_rotation.leftCols<2>();
  return jacobian;
}

Eigen::Matrix<double, 2, kRigDim> ByRig(const PredictedPixel& predicted, const Rig& rig) {
  Eigen::Matrix<double, 2, kRigDim> jacobian;
  jacobian << -predicted.by_cam * Skew(predicted.x_in_cam - rig.cam_from_imu.translation),
      predicted.by_cam, Eigen::Vector2d::Zero();
  return jacobian;
}

}  // namespace cairn::fusion
