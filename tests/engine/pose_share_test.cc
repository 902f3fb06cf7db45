#include "engine/tiles/pose_share.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/angles.h"

namespace cairn {
namespace {

SearchRegion RegionOf(double prior_sigma_m) {
  SearchRegion region;
  region.has_prior = true;
  region.prior_sigma_m = prior_sigma_m;
  region.radius_m = 50.0;
  return region;
}

PoseEstimate EstimateOf(double log_volume, double log_tilt_density = 0.0) {
  PoseEstimate estimate;
  estimate.log_volume = log_volume;
  estimate.log_tilt_density = log_tilt_density;
  return estimate;
}

double ShareAt(const Eigen::Vector3d& center, const PoseEstimate& estimate) {
  return LogPoseShare(RegionOf(10.0), center, estimate);
}

// Inliers that fix the pose to millimeters had more poses to choose from than inliers that fix it
// to a meter.
TEST(LogPoseShare, FallsAsTheInliersDistinguishMorePoses) {
  const double sharp = ShareAt({0, 0, 0}, EstimateOf(-25.0));
  EXPECT_NEAR(ShareAt({0, 0, 0}, EstimateOf(-15.0)) - sharp, 10.0, 1e-9);
  EXPECT_NEAR(ShareAt({0, 0, 0}, EstimateOf(-25.0, 6.0)) - sharp, 6.0, 1e-9);
}

TEST(LogPoseShare, IsThatOfTheWholePriorAtMost) {
  EXPECT_EQ(ShareAt({0, 0, 0}, EstimateOf(100.0)), 0.0);
  PoseEstimate estimate = EstimateOf(100.0);
  estimate.log_camera_share = -2.0;
  EXPECT_EQ(ShareAt({0, 0, 0}, estimate), -2.0);
}

TEST(LogPoseShare, IsTheDensityOfThePriorTimesTheVolume) {
  // Positions 1 / (2 pi sigma^2), heights over 5 m, headings over the full circle.
  EXPECT_NEAR(ShareAt({0, 0, 3}, EstimateOf(-20.0)),
              -20.0 - std::log(2.0 * kPi * 100.0 * 5.0 * 2.0 * kPi), 1e-9);
  EXPECT_LT(ShareAt({40, 0, 0}, EstimateOf(-20.0)), ShareAt({0, 0, 0}, EstimateOf(-20.0)) - 2.0);
  SearchRegion anywhere = RegionOf(10.0);
  anywhere.has_prior = false;
  anywhere.area_m2 = kPi * 250000.0;
  EXPECT_NEAR(LogPoseShare(anywhere, {400, 0, 0}, EstimateOf(-20.0)),
              -20.0 - std::log(kPi * 250000.0 * 5.0 * 2.0 * kPi), 1e-9);
}

}  // namespace
}  // namespace cairn
