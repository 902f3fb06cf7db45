#include "fusion/filter/point_chart.h"

#include "core/rotation_between.h"

namespace cairn::fusion {

PointChart::PointChart(const Eigen::Vector3d& center, const Eigen::Vector3d& x) : center_(center) {
  const Eigen::Vector3d way = x - center;
  axes_ = RotationBetween(Eigen::Vector3d::UnitZ(), way).toRotationMatrix();
  origin_ = {0.0, 0.0, 1.0 / way.norm()};
}

}  // namespace cairn::fusion
