// Bounds of options.
#ifndef CAIRN_ENGINE_MATCHING_REQUIRE_WITHIN_H_
#define CAIRN_ENGINE_MATCHING_REQUIRE_WITHIN_H_

#include <fmt/format.h>

#include <string_view>

#include "core/error.h"

namespace cairn {

// Throws Error(kInvalidArgument), naming the field, unless min <= value <= max. Comparisons are
// false for NaN, so that it is refused too.
template <typename Number>
void RequireWithin(std::string_view field, Number value, Number min, Number max) {
  if (!(value >= min && value <= max)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{} is {}; it must lie in [{}, {}]", field, value, min, max));
  }
}

}  // namespace cairn

#endif  // CAIRN_ENGINE_MATCHING_REQUIRE_WITHIN_H_
