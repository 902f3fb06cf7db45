#include "engine/voting/voting_options.h"

#include <fmt/format.h>

#include "core/check.h"
#include "core/error.h"

namespace cairn {
namespace {

void Require(bool condition, const char* what) {
  if (!condition) {
    throw Error(ErrorCode::kInvalidArgument, fmt::format("voting option {}", what));
  }
}

}  // namespace

const char* OutlierFilterName(OutlierFilter filter) {
  switch (filter) {
    case OutlierFilter::kVoting4d:
      return "voting_4d";
    case OutlierFilter::kVoting3d:
      return "voting_3d";
    case OutlierFilter::kCovisibility:
      return "covisibility";
    case OutlierFilter::kNone:
      return "none";
  }
  CAIRN_CHECK(false, "an OutlierFilter has a name");
  return "";
}

void VotingOptions::Validate() const {
  Require(cell_xy_m >= 0.1 && cell_xy_m <= 100.0, "cell_xy_m must lie in [0.1, 100]");
  Require(cell_z_m >= 0.1 && cell_z_m <= 100.0, "cell_z_m must lie in [0.1, 100]");
  Require(yaw_step_rad >= 0.005 && yaw_step_rad <= 0.8, "yaw_step_rad must lie in [0.005, 0.8]");
  Require(max_candidates >= 1 && max_candidates <= 1000, "max_candidates must lie in [1, 1000]");
  Require(min_score >= 0.0 && min_score < 1e6, "min_score must not be negative");
  Require(max_distance_m > 0.0 && max_distance_m <= 1e5, "max_distance_m must lie in (0, 1e5]");
  Require(max_distance_factor == 0.0 || (max_distance_factor > 1.0 && max_distance_factor < 1e6),
          "max_distance_factor must be 0 or above 1");
  Require(max_azimuth_difference_rad > 0.0 && max_azimuth_difference_rad <= 3.1416,
          "max_azimuth_difference_rad must lie in (0, pi]");
  Require(direction_tolerance_rad > 0.0 && direction_tolerance_rad <= 1.0,
          "direction_tolerance_rad must lie in (0, 1]");
}

}  // namespace cairn
