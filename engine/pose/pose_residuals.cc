#include "engine/pose/pose_residuals.h"

#include <Eigen/Cholesky>

#include "core/frames.h"

namespace cairn {

Rigid3d PerturbPose(const Rigid3d& anchor_from_cam, const PoseTangent& tangent) {
  return {ExpSo3(tangent.head<3>()) * anchor_from_cam.rotation,
          anchor_from_cam.translation + tangent.tail<3>()};
}

std::optional<ErrorShape> ErrorShapeAt(const PosedCamera& camera,
                                       const Eigen::Vector3d& x_in_anchor,
                                       const LandmarkShape& shape_in_anchor,
                                       double keypoint_sigma_px) {
  Eigen::Matrix<double, 2, 3> pixel_by_anchor;
  if (!ProjectLandmark(camera, x_in_anchor, &pixel_by_anchor)) {
    return std::nullopt;
  }
  const Eigen::Matrix2d relative_to_keypoint =
      Eigen::Matrix2d::Identity() + pixel_by_anchor * shape_in_anchor.covariance_sq_m *
                                        pixel_by_anchor.transpose() /
                                        (keypoint_sigma_px * keypoint_sigma_px);
  const Eigen::Matrix2d whitening =
      relative_to_keypoint.llt().matrixL().solve(Eigen::Matrix2d::Identity());
  return ErrorShape{whitening, whitening * pixel_by_anchor * shape_in_anchor.by_distance_m};
}

Eigen::Vector3d GravityResidual(const Eigen::Vector3d& down_in_cam, const Rigid3d& anchor_from_cam,
                                Eigen::Matrix<double, 3, 6>* jacobian) {
  const Eigen::Matrix3d cam_from_anchor = anchor_from_cam.rotation.conjugate().toRotationMatrix();
  if (jacobian != nullptr) {
    jacobian->leftCols<3>() = cam_from_anchor * Skew(DownInEnu());
    jacobian->rightCols<3>().setZero();
  }
  return cam_from_anchor * DownInEnu() - down_in_cam;
}

}  // namespace cairn
