// Statistics of a few numbers.
#ifndef CAIRN_CORE_STATISTICS_H_
#define CAIRN_CORE_STATISTICS_H_

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/check.h"

namespace cairn {

// Returns the middle of the values, of an even number the upper one. There must be a value. Linear.
template <typename T>
T Median(std::vector<T> values) {
  CAIRN_CHECK(!values.empty(), "a median needs a value");
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Returns the point whose coordinates are the medians of those of the points.
inline Eigen::Vector3d MedianPoint(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d median;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> coordinates;
    for (const Eigen::Vector3d& point : points) {
      coordinates.push_back(point[axis]);
    }
    median[axis] = Median(std::move(coordinates));
  }
  return median;
}

}  // namespace cairn

#endif  // CAIRN_CORE_STATISTICS_H_
