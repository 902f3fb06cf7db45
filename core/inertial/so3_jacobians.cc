#include "core/inertial/so3_jacobians.h"

#include <cmath>

#include "core/rigid3.h"

namespace cairn::fusion {
namespace {

// Below this angle the quotients lose digits, so series are used.
constexpr double kSmallAngle = 1e-2;

}  // namespace

Eigen::Matrix3d LeftJacobian(const Eigen::Vector3d& rotation_vector) {
  const double t = rotation_vector.norm();
  const double tt = t * t;
  const bool small = t < kSmallAngle;
  const double a = small ? 0.5 - tt / 24.0 : (1.0 - std::cos(t)) / tt;
  const double b = small ? 1.0 / 6.0 - tt / 120.0 : (t - std::sin(t)) / (tt * t);
  const Eigen::Matrix3d w = Skew(rotation_vector);
  return Eigen::Matrix3d::Identity() + a * w + b * w * w;
}

Eigen::Matrix3d InverseLeftJacobian(const Eigen::Vector3d& rotation_vector) {
  const double t = rotation_vector.norm();
  const double tt = t * t;
  const double c = t < kSmallAngle ? 1.0 / 12.0 + tt / 720.0
                                   : 1.0 / tt - (1.0 + std::cos(t)) / (2.0 * t * std::sin(t));
  const Eigen::Matrix3d w = Skew(rotation_vector);
  return Eigen::Matrix3d::Identity() - 0.5 * w + c * w * w;
}

}  // namespace cairn::fusion
