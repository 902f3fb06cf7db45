#include "engine/query/level_frame.h"

namespace cairn {

Eigen::Quaterniond LevelFromCam(const Eigen::Vector3d& down_in_cam) {
  constexpr double kMinHorizontal = 1e-3;
  const Eigen::Vector3d up_in_cam = -down_in_cam.normalized();
  const auto horizontal = [&](const Eigen::Vector3d& direction) -> Eigen::Vector3d {
    return direction - up_in_cam * up_in_cam.dot(direction);
  };
  Eigen::Vector3d forward_in_cam = horizontal(Eigen::Vector3d::UnitZ());
  if (forward_in_cam.norm() < kMinHorizontal) {
    forward_in_cam = horizontal(Eigen::Vector3d::UnitY());
  }
  forward_in_cam.normalize();
  Eigen::Matrix3d level_from_cam;
  level_from_cam.row(0) = forward_in_cam;
  level_from_cam.row(1) = up_in_cam.cross(forward_in_cam);
  level_from_cam.row(2) = up_in_cam;
  return Eigen::Quaterniond(level_from_cam);
}

}  // namespace cairn
