#include "storage/inspection/geo_box.h"

#include <gtest/gtest.h>

namespace cairn {
namespace {

TEST(BoxesMeet, IncludesTheEdges) {
  const GeoBox box = {0.1, 0.1, 0.2, 0.2};
  EXPECT_TRUE(BoxesMeet(box, {0.2, 0.2, 0.3, 0.3}));
  EXPECT_TRUE(BoxesMeet(box, {0.0, 0.0, 0.3, 0.3}));
  EXPECT_TRUE(BoxesMeet({0.0, 0.0, 0.3, 0.3}, box));
  EXPECT_FALSE(BoxesMeet(box, {0.1, 0.21, 0.2, 0.3}));
  EXPECT_FALSE(BoxesMeet(box, {0.21, 0.1, 0.3, 0.2}));
}

TEST(BoxesMeet, CrossesTheAntimeridian) {
  const GeoBox crossing = {0.0, 3.0, 1.0, -3.0};
  EXPECT_TRUE(BoxesMeet(crossing, {0.0, 3.1, 1.0, 3.12}));
  EXPECT_TRUE(BoxesMeet({0.0, -3.1, 1.0, -3.05}, crossing));
  EXPECT_TRUE(BoxesMeet(crossing, {0.0, 3.13, 1.0, -3.13}));
  EXPECT_FALSE(BoxesMeet(crossing, {0.0, -2.9, 1.0, 2.9}));
}

TEST(BoxAroundAll, LeavesOutTheWidestGap) {
  EXPECT_FALSE(BoxAroundAll({}).has_value());
  const GeoBox near = *BoxAroundAll({{0.5, 0.2, 0.6, 0.3}, {0.1, 0.4, 0.2, 0.5}});
  EXPECT_EQ(near.south_rad, 0.1);
  EXPECT_EQ(near.west_rad, 0.2);
  EXPECT_EQ(near.north_rad, 0.6);
  EXPECT_EQ(near.east_rad, 0.5);
  const GeoBox far = *BoxAroundAll({{0.0, -3.1, 0.1, -3.0}, {0.0, 3.0, 0.1, 3.1}});
  EXPECT_TRUE(far.CrossesAntimeridian());
  EXPECT_EQ(far.west_rad, 3.0);
  EXPECT_NEAR(far.east_rad, -3.0, 1e-12);
  const GeoBox one = *BoxAroundAll({{0.0, 3.1, 0.1, -3.1}});
  EXPECT_EQ(one.west_rad, 3.1);
  EXPECT_NEAR(one.east_rad, -3.1, 1e-12);
}

TEST(BoxAroundAll, ABoxOverTheAntimeridianCoversThoseBeyondIt) {
  const GeoBox wide = *BoxAroundAll({{0.0, 3.0, 0.1, -3.0}, {0.0, -3.1, 0.1, -3.05}});
  EXPECT_EQ(wide.west_rad, 3.0);
  EXPECT_NEAR(wide.east_rad, -3.0, 1e-12);
}

TEST(BoxAroundAll, WithoutAGapItSpansAllLongitudes) {
  const GeoBox all = *BoxAroundAll({{0.0, -3.0, 0.1, 1.0}, {0.0, 0.5, 0.1, -2.9}});
  EXPECT_LT(all.west_rad, -3.14);
  EXPECT_GT(all.east_rad, 3.14);
}

}  // namespace
}  // namespace cairn
