// Coordinates of a point in which its image is nearly linear, even if its distance is not well
// known.
#ifndef CAIRN_FUSION_FILTER_POINT_CHART_H_
#define CAIRN_FUSION_FILTER_POINT_CHART_H_

#include <Eigen/Core>

namespace cairn::fusion {

// A point is at center + axes * (a, b, 1) / c. Here (a, b) is its direction and c its inverse
// distance, seen from `center` (Civera et al. 2008). Its error is the error of (a, b, c).
class PointChart {
 public:
  PointChart() = default;
  // Makes a chart whose axis points from `center` to `x`. The two points are in the same frame and
  // must differ.
  PointChart(const Eigen::Vector3d& center, const Eigen::Vector3d& x);

  // Coordinates of the point `x` for which the chart was made.
  const Eigen::Vector3d& origin() const { return origin_; }

  Eigen::Vector3d ToPoint(const Eigen::Vector3d& coordinates) const {
    return center_ +
           axes_ * Eigen::Vector3d(coordinates.x(), coordinates.y(), 1.0) / coordinates.z();
  }

  // Inverse of ToPoint, for points on the same side of the chart as its `x`.
  Eigen::Vector3d FromPoint(const Eigen::Vector3d& x) const {
    const Eigen::Vector3d way = axes_.transpose() * (x - center_);
    return {way.x() / way.z(), way.y() / way.z(), 1.0 / way.z()};
  }

  // Derivative of ToPoint.
  Eigen::Matrix3d Jacobian(const Eigen::Vector3d& coordinates) const {
    const double distance_m = 1.0 / coordinates.z();
    Eigen::Matrix3d by_coordinates = distance_m * Eigen::Matrix3d::Identity();
    by_coordinates.col(2) =
        -distance_m * distance_m * Eigen::Vector3d(coordinates.x(), coordinates.y(), 1.0);
    return axes_ * by_coordinates;
  }

 private:
  Eigen::Vector3d center_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin_ = Eigen::Vector3d::UnitZ();
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_FILTER_POINT_CHART_H_
