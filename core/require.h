// Checks of options. Errors name the field.
#ifndef CAIRN_CORE_REQUIRE_H_
#define CAIRN_CORE_REQUIRE_H_

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <type_traits>

#include "core/error.h"

namespace cairn {

// Throws Error(kInvalidArgument) with the message `what`, e.g. "pose.min_inliers must be at least
// 4", unless the condition holds.
inline void RequireOption(bool condition, std::string_view what) {
  if (!condition) {
    throw Error(ErrorCode::kInvalidArgument, std::string(what));
  }
}

// Throws Error(kInvalidArgument), naming the field and the nearest possible value, unless min <=
// value <= max. NaN is refused, since comparisons with NaN are false.
template <typename Value, typename Min, typename Max>
void RequireWithin(std::string_view field, Value value, Min min, Max max) {
  using Number = std::common_type_t<Value, Min, Max>;
  const Number number = value, low = min, high = max;
  if (!(number >= low && number <= high)) {
    const std::string nearest = number == number ? fmt::format("; the nearest possible value is {}",
                                                               std::clamp(number, low, high))
                                                 : "";
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{} = {} must lie in [{}, {}]{}", field, value, min, max, nearest));
  }
}

}  // namespace cairn

#endif  // CAIRN_CORE_REQUIRE_H_
