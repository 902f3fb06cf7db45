#include "core/rotation_between.h"

namespace cairn {

Eigen::Quaterniond RotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to);
}

double YawRad(const Eigen::Quaterniond& rotation) {
  const Eigen::Matrix3d matrix = rotation.toRotationMatrix();
  return std::atan2(matrix(1, 0) - matrix(0, 1), matrix(0, 0) + matrix(1, 1));
}

}  // namespace cairn
