#include "fusion/estimator/fusion_options.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "core/error.h"

namespace cairn::fusion {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct Nonsense {
  const char* field;
  void (*set)(FusionOptions*);
};

// One of each room's options, zeros, negative numbers, numbers out of range and NaN among them.
const Nonsense kNonsense[] = {
    {"imu_noise", [](FusionOptions* options) { options->imu_noise.gyro_walk = 0.0; }},
    {"gravity_m_s2", [](FusionOptions* options) { options->gravity_m_s2 = kNan; }},
    {"max_clones", [](FusionOptions* options) { options->max_clones = 17; }},
    {"query.max_pending", [](FusionOptions* options) { options->query.max_pending = 0; }},
    {"max_clones and query.max_pending",
     [](FusionOptions* options) {
       options->max_clones = 16;
       options->query.max_pending = 3;
     }},
    {"steady.max_held_back_rad",
     [](FusionOptions* options) { options->steady.max_held_back_rad = 4.0; }},
    {"state.tile_sigma_m",
     [](FusionOptions* options) {
       options->state.tile_sigma_m = std::numeric_limits<double>::infinity();
     }},
    {"state.max_points", [](FusionOptions* options) { options->state.max_points = -1; }},
    {"standstill.window_s", [](FusionOptions* options) { options->standstill.window_s = kNan; }},
    {"dynamic_start.window_s",
     [](FusionOptions* options) { options->dynamic_start.window_s = 0.0; }},
    {"tracks.max_tracks", [](FusionOptions* options) { options->tracks.max_tracks = 0; }},
    {"triangulate.max_depth_m",
     [](FusionOptions* options) { options->tracks.triangulate.max_depth_m = 0.1; }},
    {"map.sigma_px", [](FusionOptions* options) { options->map.sigma_px = -1.0; }},
};

TEST(FusionOptions, HasValidDefaults) { EXPECT_NO_THROW(FusionOptions().Validate()); }

TEST(FusionOptions, RefusesNonsenseByItsName) {
  for (const Nonsense& nonsense : kNonsense) {
    FusionOptions options;
    nonsense.set(&options);
    try {
      options.Validate();
      ADD_FAILURE() << nonsense.field << " passes";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
      EXPECT_EQ(std::string(error.what()).rfind(nonsense.field, 0), 0u) << error.what();
    }
  }
}

}  // namespace
}  // namespace cairn::fusion
