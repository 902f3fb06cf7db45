// The orientation of a camera as three angles.
#ifndef CAIRN_LAB_CITY_CAMERA_ANGLES_H_
#define CAIRN_LAB_CITY_CAMERA_ANGLES_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "core/rigid3.h"

namespace cairn {

struct CameraAngles {
  double yaw_rad = 0.0;    // Optical axis, counterclockwise from east.
  double pitch_rad = 0.0;  // Optical axis, upward.
  double roll_rad = 0.0;   // About the optical axis, clockwise seen from behind.
};

// Returns the pose of a camera at a place in an east-north-up frame.
inline Rigid3d CamFromEnu(const Eigen::Vector3d& center_in_enu, const CameraAngles& angles) {
  const double cos_pitch = std::cos(angles.pitch_rad);
  const Eigen::Vector3d forward(cos_pitch * std::cos(angles.yaw_rad),
                                cos_pitch * std::sin(angles.yaw_rad), std::sin(angles.pitch_rad));
  const Eigen::Vector3d right(std::sin(angles.yaw_rad), -std::cos(angles.yaw_rad), 0.0);
  Eigen::Matrix3d enu_from_cam;
  enu_from_cam << right, forward.cross(right), forward;
  enu_from_cam *= Eigen::AngleAxisd(angles.roll_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return Rigid3d(enu_from_cam, center_in_enu).Inverse();
}

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_CAMERA_ANGLES_H_
