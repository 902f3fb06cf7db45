#include "engine/pose/pose_options.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/error.h"
#include "support/refused_options.h"

namespace cairn {
namespace {

TEST(PoseOptions, RejectsNonsenseNamingTheField) {
  const std::vector<testing::SpoiledField<PoseOptions>> cases = {
      {"max_error_px", [](PoseOptions* o) { o->max_error_px = 0.0; }},
      {"max_error_px", [](PoseOptions* o) { o->max_error_px = std::nan(""); }},
      {"keypoint_sigma_px", [](PoseOptions* o) { o->keypoint_sigma_px = -1.0; }},
      {"min_iterations", [](PoseOptions* o) { o->min_iterations = 0; }},
      {"max_iterations", [](PoseOptions* o) { o->max_iterations = o->min_iterations - 1; }},
      {"distance_weight", [](PoseOptions* o) { o->distance_weight = -1.0; }},
      {"min_inliers", [](PoseOptions* o) { o->min_inliers = 3; }},
      {"gravity_sigma_rad", [](PoseOptions* o) { o->gravity_sigma_rad = 0.0; }},
  };
  testing::ExpectRefused(PoseOptions(), cases);
}

TEST(PoseOptions, ThresholdGrowsWithFocalLength) {
  PoseOptions options;
  options.max_error_px = 4.0;
  EXPECT_DOUBLE_EQ(options.MaxErrorPx(500.0), 4.0);
  EXPECT_DOUBLE_EQ(options.MaxErrorPx(2000.0), 16.0);
  EXPECT_DOUBLE_EQ(options.MaxErrorPx(100.0), 2.0);
}

}  // namespace
}  // namespace cairn
