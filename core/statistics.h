// Statistics of a few numbers.
#ifndef CAIRN_CORE_STATISTICS_H_
#define CAIRN_CORE_STATISTICS_H_

#include <algorithm>
#include <cstddef>
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

}  // namespace cairn

#endif  // CAIRN_CORE_STATISTICS_H_
