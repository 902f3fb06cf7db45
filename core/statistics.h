// Statistics of numbers and angles.
#ifndef CAIRN_CORE_STATISTICS_H_
#define CAIRN_CORE_STATISTICS_H_

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
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

// Returns the value whose rank among n sorted ones is `share` in [0, 1] of n - 1, rounded down: one
// of the values. There must be a value. Linear.
template <typename T>
T ValueAtShare(std::vector<T> values, double share) {
  CAIRN_CHECK(!values.empty(), "a quantile needs a value");
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// As ValueAtShare, but between two ranks a number in proportion between their values. Sorts.
inline double Quantile(std::vector<double> values, double share) {
  CAIRN_CHECK(!values.empty(), "a quantile needs a value");
  std::sort(values.begin(), values.end());
  const double rank = share * static_cast<double>(values.size() - 1);
  const auto lower = static_cast<size_t>(rank);
  const size_t upper = std::min(lower + 1, values.size() - 1);
  const double fraction = rank - static_cast<double>(lower);
  return values[lower] + fraction * (values[upper] - values[lower]);
}

// The mean direction of angles: that of the sum of their unit vectors.
class CircularMean {
 public:
  void Add(double angle_rad, double weight = 1.0) {
    sum_ += weight * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
  }
  // Nothing if no angle was added or they cancel.
  std::optional<double> AngleRad() const {
    if (!(sum_.norm() > 1e-9)) {
      return std::nullopt;
    }
    return std::atan2(sum_.y(), sum_.x());
  }

 private:
  Eigen::Vector2d sum_ = Eigen::Vector2d::Zero();
};

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
