#include "engine/tiles/search_region.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "engine/tiles/pose_share.h"

namespace cairn {
namespace {

PositionPrior PriorOf(double accuracy_m) {
  return {Geodetic::FromDegrees(47.0, 8.0, 400.0), accuracy_m, std::nullopt};
}

TEST(SearchRegion, RadiusFollowsTheAccuracy) {
  // The disc of 30 m holds 68 %: sigma = 30 / sqrt(-2 ln 0.32) = 19.87 m an axis.
  const SearchRegion region = RegionOfPrior(PriorOf(30.0), PriorOptions{});
  EXPECT_TRUE(region.has_prior);
  EXPECT_NEAR(region.prior_sigma_m, 19.87, 0.01);
  EXPECT_NEAR(region.radius_m, 3.0 * 19.87, 0.05);
  EXPECT_DOUBLE_EQ(region.origin.h_m, 0.0);
}

TEST(SearchRegion, RadiusStaysWithinItsBounds) {
  const PriorOptions options;
  EXPECT_DOUBLE_EQ(RegionOfPrior(PriorOf(0.5), options).radius_m, options.min_radius_m);
  EXPECT_DOUBLE_EQ(RegionOfPrior(PriorOf(5000.0), options).radius_m, options.max_radius_m);
}

TEST(SearchRegion, HeightOfThePriorBoundsTheCamera) {
  PositionPrior prior = PriorOf(10.0);
  prior.height_sigma_m = 4.0;
  const SearchRegion region = RegionOfPrior(prior, PriorOptions{});
  EXPECT_DOUBLE_EQ(region.min_z_m, 388.0);
  EXPECT_DOUBLE_EQ(region.max_z_m, 412.0);
}

TEST(SearchRegion, APlaceIsADiscAndThePriorProbabilityThatOfTheWholeMap) {
  const Geodetic center = Geodetic::FromDegrees(-17.0, 179.9999, 60.0);
  const SearchRegion region = RegionOfPlace(center, 75.0, 400);
  EXPECT_FALSE(region.has_prior);
  EXPECT_LT(GroundDistanceM(region.origin, center), 1e-3);
  EXPECT_DOUBLE_EQ(region.origin.h_m, 0.0);
  EXPECT_DOUBLE_EQ(region.radius_m, 75.0);
  EXPECT_NEAR(
      LogPoseShare(RegionOfPlace(center, 75.0, 1), Eigen::Vector3d::Zero(), PoseEstimate()) -
          LogPoseShare(region, Eigen::Vector3d::Zero(), PoseEstimate()),
      std::log(400.0), 1e-9);
}

TEST(SearchRegion, BoundsHoldTheDisc) {
  const SearchRegion region = RegionOfPrior(PriorOf(30.0), PriorOptions{});
  const GeoBox box = RegionBounds(region);
  const Geodetic north{box.north_rad, region.origin.lon_rad, 0.0};
  EXPECT_GE(GroundDistanceM(region.origin, north), region.radius_m);
}

TEST(PriorOptions, RefuseNonsense) {
  PriorOptions options;
  options.max_radius_m = 1.0;
  EXPECT_THROW(options.Validate(), Error);
}

}  // namespace
}  // namespace cairn
