#include "engine/pose/gravity_two_point.h"

#include <cmath>

namespace cairn {

int SolveGravityTwoPoint(const std::array<Eigen::Vector3d, 2>& bearings_in_level,
                         const std::array<Eigen::Vector3d, 2>& x_in_anchor,
                         std::array<LevelPose, 2>* solutions,
                         const std::array<Eigen::Vector3d, 2>& origins_in_level) {
  constexpr double kMinSlope = 1e-9;
  constexpr double kMinDistanceM = 1e-9;
  const Eigen::Vector3d& b1 = bearings_in_level[0];
  const Eigen::Vector3d& b2 = bearings_in_level[1];
  const Eigen::Vector3d difference = x_in_anchor[0] - x_in_anchor[1];
  const Eigen::Vector3d offset = origins_in_level[0] - origins_in_level[1];
  const double slope = std::hypot(b1.z(), b2.z());
  const double distance_xy = difference.head<2>().norm();
  if (!(slope > kMinSlope) || !(distance_xy > kMinDistanceM)) {
    return 0;
  }
  // The depths are (l1, l2) = base + s * step; the horizontal vector between the points is then u +
  // s v.
  const double base = (difference.z() - offset.z()) / (slope * slope);
  const double base1 = base * b1.z(), base2 = -base * b2.z();
  const double step1 = b2.z() / slope, step2 = b1.z() / slope;
  const Eigen::Vector2d u = base1 * b1.head<2>() - base2 * b2.head<2>() + offset.head<2>();
  const Eigen::Vector2d v = step1 * b1.head<2>() - step2 * b2.head<2>();
  const double a = v.squaredNorm();
  if (!(a > kMinSlope * kMinSlope)) {
    return 0;
  }
  const double half_b = u.dot(v);
  // half_b^2 - a c, rearranged to avoid cancellation: |u x v|^2 = |u|^2 |v|^2 - (u.v)^2.
  const double cross = u.x() * v.y() - u.y() * v.x();
  const double discriminant = a * distance_xy * distance_xy - cross * cross;
  if (!(discriminant >= 0.0)) {
    return 0;
  }
  const double root = std::sqrt(discriminant);
  const int num_roots = root > 0.0 ? 2 : 1;
  int num_solutions = 0;
  for (int i = 0; i < num_roots; ++i) {
    const double s = (-half_b + (i == 0 ? root : -root)) / a;
    const double l1 = base1 + s * step1;
    const double l2 = base2 + s * step2;
    if (!(l1 > 0.0) || !(l2 > 0.0)) {
      continue;
    }
    // The rotation from w = u + s v to the horizontal difference of the landmarks.
    const Eigen::Vector2d w = u + s * v;
    const double scale = 1.0 / (distance_xy * w.norm());
    const double cos_yaw = (w.x() * difference.x() + w.y() * difference.y()) * scale;
    const double sin_yaw = (w.x() * difference.y() - w.y() * difference.x()) * scale;
    LevelPose& pose = (*solutions)[num_solutions++];
    pose.yaw_direction = {cos_yaw, sin_yaw};
    const Eigen::Vector3d x_in_level = origins_in_level[0] + l1 * b1;
    pose.center_in_anchor =
        x_in_anchor[0] - Eigen::Vector3d(cos_yaw * x_in_level.x() - sin_yaw * x_in_level.y(),
                                         sin_yaw * x_in_level.x() + cos_yaw * x_in_level.y(),
                                         x_in_level.z());
  }
  return num_solutions;
}

}  // namespace cairn
