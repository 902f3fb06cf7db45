// The rotation from one direction to another.
#ifndef CAIRN_CORE_ROTATION_BETWEEN_H_
#define CAIRN_CORE_ROTATION_BETWEEN_H_

#include <Eigen/Geometry>

namespace cairn {

// Returns the smallest rotation that turns the direction of `from` to that of `to`. Neither may be
// zero. If the directions are opposite, one of the half turns is returned.
//
// This is Eigen's FromTwoVectors, which instantiates a singular value decomposition: 6 s of compile
// time in each file that calls it.
Eigen::Quaterniond RotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace cairn

#endif  // CAIRN_CORE_ROTATION_BETWEEN_H_
