#include "core/rigid3.h"

#include <algorithm>
#include <cmath>

namespace cairn {

Eigen::Quaterniond ExpSo3(const Eigen::Vector3d& rotation_vector) {
  const double angle_rad = rotation_vector.norm();
  // sin(x / 2) / x, by its series where the quotient would lose digits.
  const double factor =
      angle_rad < 1e-4 ? 0.5 - angle_rad * angle_rad / 48.0 : std::sin(0.5 * angle_rad) / angle_rad;
  const Eigen::Vector3d imaginary = factor * rotation_vector;
  return {std::cos(0.5 * angle_rad), imaginary.x(), imaginary.y(), imaginary.z()};
}

Eigen::Vector3d LogSo3(const Eigen::Quaterniond& rotation) {
  const double sign = rotation.w() < 0.0 ? -1.0 : 1.0;  // Selects the shorter of the two rotations.
  const double sin_half = rotation.vec().norm();
  const double angle_rad = 2.0 * std::atan2(sin_half, sign * rotation.w());
  const double factor = sin_half < 1e-8 ? 2.0 : angle_rad / sin_half;
  return sign * factor * rotation.vec();
}

Eigen::Matrix3d Skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d matrix;
  // clang-format off
  matrix <<    0.0, -a.z(),  a.y(),
             a.z(),    0.0, -a.x(),
            -a.y(),  a.x(),    0.0;
  // clang-format on
  return matrix;
}

double RotationAngleRad(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return LogSo3(a * b.conjugate()).norm();
}

}  // namespace cairn
