// Rotations and angles from one direction to another.
#ifndef CAIRN_CORE_ROTATION_BETWEEN_H_
#define CAIRN_CORE_ROTATION_BETWEEN_H_

#include <Eigen/Geometry>
#include <cmath>

namespace cairn {

// Returns the smallest rotation that turns the direction of `from` to that of `to`. Neither may be
// zero. If the directions are opposite, one of the half turns is returned.
//
// This is Eigen's FromTwoVectors, which instantiates a singular value decomposition: 6 s of compile
// time in each file that calls it.
Eigen::Quaterniond RotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

// Returns the angle between two directions of any length, radians in [0, pi]. Exact also for small
// angles and for angles near pi, where the arc cosine of the dot product is not.
inline double AngleBetweenRad(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// Returns the angle about the z axis of the rotation about z that is nearest to `rotation`, radians
// in (-pi, pi].
double YawRad(const Eigen::Quaterniond& rotation);

}  // namespace cairn

#endif  // CAIRN_CORE_ROTATION_BETWEEN_H_
