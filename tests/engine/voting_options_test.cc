#include "engine/voting/voting_options.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/refused_options.h"

namespace cairn {
namespace {

TEST(VotingOptions, RejectsNonsenseNamingTheField) {
  const std::vector<testing::SpoiledField<VotingOptions>> cases = {
      {"cell_xy_m", [](VotingOptions* o) { o->cell_xy_m = 0.0; }},
      {"cell_z_m", [](VotingOptions* o) { o->cell_z_m = std::nan(""); }},
      {"yaw_step_rad", [](VotingOptions* o) { o->yaw_step_rad = 0.0; }},
      {"max_candidates", [](VotingOptions* o) { o->max_candidates = 0; }},
      {"min_score", [](VotingOptions* o) { o->min_score = -1.0; }},
      {"max_distance_m", [](VotingOptions* o) { o->max_distance_m = 0.0; }},
      {"max_distance_factor", [](VotingOptions* o) { o->max_distance_factor = 0.5; }},
      {"max_azimuth_difference_rad", [](VotingOptions* o) { o->max_azimuth_difference_rad = 4.0; }},
      {"direction_tolerance_rad", [](VotingOptions* o) { o->direction_tolerance_rad = 0.0; }},
  };
  testing::ExpectRefused(VotingOptions(), cases);
}

}  // namespace
}  // namespace cairn
