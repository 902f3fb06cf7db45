#include "engine/refinement/refinement_options.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"

namespace cairn {
namespace {

void Require(bool condition, const char* what) {
  if (!condition) {
    throw Error(ErrorCode::kInvalidArgument, fmt::format("refinement option {}", what));
  }
}

}  // namespace

void RefinementOptions::Validate() const {
  Require(good_effective_inliers >= 0.0 && std::isfinite(good_effective_inliers),
          "good_effective_inliers must not be negative");
  Require(max_keyframes >= 0 && max_keyframes <= 1000, "max_keyframes must lie in [0, 1000]");
  Require(neighbors_per_keyframe >= 0 && neighbors_per_keyframe <= 1000,
          "neighbors_per_keyframe must lie in [0, 1000]");
  Require(min_separation_m >= 0.0 && std::isfinite(min_separation_m),
          "min_separation_m must not be negative");
  Require(relaxed_distance_quantile > 0.0 && relaxed_distance_quantile <= 1.0,
          "relaxed_distance_quantile must lie in (0, 1]");
}

}  // namespace cairn
