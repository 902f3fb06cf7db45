#include "engine/pose/pose_residuals.h"

#include "core/frames.h"

namespace cairn {

Rigid3d PerturbPose(const Rigid3d& anchor_from_cam, const PoseTangent& tangent) {
  return {ExpSo3(tangent.head<3>()) * anchor_from_cam.rotation,
          anchor_from_cam.translation + tangent.tail<3>()};
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
