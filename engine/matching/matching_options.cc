#include "engine/matching/matching_options.h"

#include <fmt/format.h>

#include <numbers>
#include <string_view>

#include "core/error.h"

namespace cairn {
namespace {

// Comparisons are false for NaN, so that it is refused too.
template <typename Number>
void RequireWithin(std::string_view field, Number value, Number min, Number max) {
  if (!(value >= min && value <= max)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{} is {}; it must lie in [{}, {}]", field, value, min, max));
  }
}

}  // namespace

void RandomGridsOptions::Validate() const {
  RequireWithin("matching.grids.num_grids", num_grids, 1, 64);
  RequireWithin("matching.grids.num_hashed_dims", num_hashed_dims, 1, 128);
  RequireWithin("matching.grids.cell_width_sigmas", cell_width_sigmas, 1e-3, 1e3);
  RequireWithin("matching.grids.num_probes", num_probes, 1, 32);
  RequireWithin("matching.grids.max_candidates_per_cell", max_candidates_per_cell, 1, 10'000);
}

void MatchingOptions::Validate() const {
  grids.Validate();
  RequireWithin("matching.max_neighbors", max_neighbors, 1, 64);
  RequireWithin("matching.distance_quantile", distance_quantile, 0.05, 0.95);
  RequireWithin("matching.orientation_weight", orientation_weight, 0.0, 1e6);
  RequireWithin("matching.position_weight", position_weight, 0.0, 1e6);
  RequireWithin("matching.viewing_distance_m", viewing_distance_m, 0.0, 1e6);
  RequireWithin("matching.max_orientation_difference_rad", max_orientation_difference_rad, 1e-3,
                std::numbers::pi);
}

}  // namespace cairn
