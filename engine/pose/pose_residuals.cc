#include "engine/pose/pose_residuals.h"

#include "core/frames.h"

namespace cairn {

Rigid3d PerturbPose(const Rigid3d& anchor_from_cam, const PoseTangent& tangent) {
  return {ExpSo3(tangent.head<3>()) * anchor_from_cam.rotation,
          anchor_from_cam.translation + tangent.tail<3>()};
}

std::optional<Eigen::Vector2d> ReprojectionResidual(const Camera& camera,
                                                    const Eigen::Vector2d& pixel,
                                                    const Eigen::Vector3d& x_in_anchor,
                                                    const Rigid3d& anchor_from_cam,
                                                    Eigen::Matrix<double, 2, 6>* jacobian) {
  const Eigen::Quaterniond cam_from_anchor = anchor_from_cam.rotation.conjugate();
  const Eigen::Vector3d from_center = x_in_anchor - anchor_from_cam.translation;
  const Eigen::Vector3d x_in_cam = cam_from_anchor * from_center;
  if (jacobian == nullptr) {
    const std::optional<Eigen::Vector2d> projected = camera.Project(x_in_cam);
    return projected ? std::optional<Eigen::Vector2d>(*projected - pixel) : std::nullopt;
  }
  Eigen::Matrix<double, 2, 3> pixel_by_point;
  const std::optional<Eigen::Vector2d> projected =
      camera.ProjectWithJacobian(x_in_cam, &pixel_by_point);
  if (!projected) {
    return std::nullopt;
  }
  // x_in_cam = R' Exp(-rotation) (x - C - translation).
  const Eigen::Matrix<double, 2, 3> pixel_by_anchor =
      pixel_by_point * cam_from_anchor.toRotationMatrix();
  jacobian->leftCols<3>() = pixel_by_anchor * Skew(from_center);
  jacobian->rightCols<3>() = -pixel_by_anchor;
  return *projected - pixel;
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
