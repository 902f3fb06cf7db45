#include "eval/city/require_option.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace cairn {

void RequireInRange(const char* field, double value, double low, double high) {
  if (value >= low && value <= high) {
    return;
  }
  const std::string nearest = std::isnan(value) ? std::string()
                                                : fmt::format("; the nearest possible value is {}",
                                                              std::clamp(value, low, high));
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("{} = {} must lie in [{}, {}]{}", field, value, low, high, nearest));
}

}  // namespace cairn
