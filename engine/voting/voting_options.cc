#include "engine/voting/voting_options.h"

#include "core/require.h"

namespace cairn {

void VotingOptions::Validate() const {
  RequireOption((filter == OutlierFilter::kOther) == static_cast<bool>(other_filter),
                "voting.other_filter must be set if and only if the filter is \"other\"");
  RequireWithin("voting.cell_xy_m", cell_xy_m, 0.1, 100.0);
  RequireWithin("voting.cell_z_m", cell_z_m, 0.1, 100.0);
  RequireWithin("voting.yaw_step_rad", yaw_step_rad, 0.005, 0.8);
  RequireWithin("voting.max_candidates", max_candidates, 1, 1000);
  RequireOption(min_score >= 0.0 && min_score < 1e6, "voting.min_score must lie in [0, 1e6)");
  RequireOption(max_distance_m > 0.0 && max_distance_m <= 1e5,
                "voting.max_distance_m must lie in (0, 1e5]");
  RequireOption(
      max_distance_factor == 0.0 || (max_distance_factor > 1.0 && max_distance_factor < 1e6),
      "voting.max_distance_factor must be 0 or lie in (1, 1e6)");
  RequireOption(max_azimuth_difference_rad > 0.0 && max_azimuth_difference_rad <= 3.1416,
                "voting.max_azimuth_difference_rad must lie in (0, pi]");
  RequireOption(direction_tolerance_rad > 0.0 && direction_tolerance_rad <= 1.0,
                "voting.direction_tolerance_rad must lie in (0, 1]");
}

}  // namespace cairn
