// The shape of the error of a landmark's position.
#ifndef CAIRN_ENGINE_QUERY_LANDMARK_SHAPE_H_
#define CAIRN_ENGINE_QUERY_LANDMARK_SHAPE_H_

#include <Eigen/Core>

namespace cairn {

struct LandmarkShape {
  Eigen::Matrix3d covariance_sq_m = Eigen::Matrix3d::Zero();  // Of the position.
  // How far one standard deviation of its distance from the cameras that mapped it moves the
  // landmark, away from them. Zero if they stand around it.
  Eigen::Vector3d by_distance_m = Eigen::Vector3d::Zero();

  LandmarkShape Rotated(const Eigen::Matrix3d& rotation) const {
    return {rotation * covariance_sq_m * rotation.transpose(), rotation * by_distance_m};
  }
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_QUERY_LANDMARK_SHAPE_H_
