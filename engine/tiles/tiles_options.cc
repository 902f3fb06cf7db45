#include "engine/tiles/tiles_options.h"

#include <fmt/format.h>

#include "core/error.h"

namespace cairn {

void TilesOptions::Validate() const {
  if (max_tiles < 1 || max_tiles > 10'000) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("tiles.max_tiles is {}; it must lie in [1, 10000]", max_tiles));
  }
  if (!(deadline_share >= 0.0 && deadline_share <= 1.0)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("tiles.deadline_share is {}; it must lie in [0, 1]", deadline_share));
  }
  if (!(height_margin_m >= 0.0 && height_margin_m <= 1e4)) {
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("tiles.height_margin_m is {}; it must lie in [0, 10000]", height_margin_m));
  }
}

}  // namespace cairn
