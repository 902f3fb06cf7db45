#include "engine/prior/search_region.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.h"

namespace cairn {
namespace {

LocalizeQuery QueryWithPrior(double accuracy_m) {
  LocalizeQuery query;
  query.prior = PositionPrior{Geodetic::FromDegrees(47.0, 8.0, 400.0), accuracy_m, std::nullopt};
  return query;
}

TEST(SearchRegion, RadiusFollowsTheAccuracy) {
  // The disc of 30 m holds 68 %: sigma = 30 / sqrt(-2 ln 0.32) = 19.87 m an axis.
  const SearchRegion region = ResolveSearchRegion(QueryWithPrior(30.0), MapInfo{}, PriorOptions{});
  EXPECT_TRUE(region.has_prior);
  EXPECT_NEAR(region.prior_sigma_m, 19.87, 0.01);
  EXPECT_NEAR(region.radius_m, 3.0 * 19.87, 0.05);
  EXPECT_DOUBLE_EQ(region.origin.h_m, 0.0);
}

TEST(SearchRegion, RadiusStaysWithinItsBounds) {
  const PriorOptions options;
  EXPECT_DOUBLE_EQ(ResolveSearchRegion(QueryWithPrior(0.5), MapInfo{}, options).radius_m,
                   options.min_radius_m);
  EXPECT_DOUBLE_EQ(ResolveSearchRegion(QueryWithPrior(5000.0), MapInfo{}, options).radius_m,
                   options.max_radius_m);
}

TEST(SearchRegion, HeightOfThePriorBoundsTheCamera) {
  LocalizeQuery query = QueryWithPrior(10.0);
  query.prior->height_sigma_m = 4.0;
  const SearchRegion region = ResolveSearchRegion(query, MapInfo{}, PriorOptions{});
  EXPECT_DOUBLE_EQ(region.min_z_m, 388.0);
  EXPECT_DOUBLE_EQ(region.max_z_m, 412.0);
}

TEST(SearchRegion, WithoutPriorItIsTheMap) {
  MapInfo map;
  const Geodetic center = Geodetic::FromDegrees(47.0, 8.0, 0.0);
  map.bounds = BoxAround(center, 200.0);
  const SearchRegion region = ResolveSearchRegion(LocalizeQuery{}, map, PriorOptions{});
  EXPECT_FALSE(region.has_prior);
  EXPECT_LT(GroundDistanceM(region.origin, center), 0.5);
  EXPECT_NEAR(region.radius_m, 200.0 * std::numbers::sqrt2, 5.0);
}

TEST(SearchRegion, WithoutPriorItMayCrossTheAntimeridian) {
  MapInfo map;
  map.bounds = BoxAround(Geodetic::FromDegrees(-17.0, 179.9999, 0.0), 100.0);
  ASSERT_TRUE(map.bounds->CrossesAntimeridian());
  const SearchRegion region = ResolveSearchRegion(LocalizeQuery{}, map, PriorOptions{});
  EXPECT_LT(region.radius_m, 160.0);
}

TEST(SearchRegion, BoundsHoldTheDisc) {
  const SearchRegion region = ResolveSearchRegion(QueryWithPrior(30.0), MapInfo{}, PriorOptions{});
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
