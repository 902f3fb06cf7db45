#include "storage/map/geo_region.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/error.h"
#include "support/map_builder.h"

namespace cairn {
namespace {

using testing::ErrorCodeOf;
using testing::TileAt;

TEST(GeoRegion, ABoxMeetsTheSquaresInAndAroundIt) {
  const GeoRegion region = GeoRegion::OfBox(49.0, 8.4, 49.01, 8.42);
  EXPECT_TRUE(region.Meets(TileAt(49.005, 8.41)));
  EXPECT_TRUE(region.Meets(TileAt(49.01, 8.42)));
  EXPECT_FALSE(region.Meets(TileAt(49.02, 8.41)));
  EXPECT_FALSE(region.Meets(TileAt(49.005, 8.43)));
  ASSERT_EQ(region.boxes().size(), 1u);
  EXPECT_NEAR(region.boxes()[0].south_rad, 49.0 / 180.0 * 3.14159265358979, 1e-9);
}

TEST(GeoRegion, ABoxWithinASquareMeetsItAlone) {
  const TileId tile = TileAt(49.005, 8.41);
  const Geodetic center = tile.Anchor();
  const GeoRegion region = GeoRegion::OfBox(center.lat_deg(), center.lon_deg(),
                                            center.lat_deg() + 1e-6, center.lon_deg() + 1e-6);
  EXPECT_TRUE(region.Meets(tile));
  EXPECT_FALSE(region.Meets(TileAt(49.01, 8.41)));
}

TEST(GeoRegion, ABoxOverTheAntimeridianMeetsBothSides) {
  const GeoRegion region = GeoRegion::OfBox(-18.0, 179.9, -17.0, -179.9);
  for (const double lon_deg : {179.95, -179.95, 180.0}) {
    EXPECT_TRUE(region.Meets(TileAt(-17.5, lon_deg))) << lon_deg;
  }
  EXPECT_FALSE(region.Meets(TileAt(-17.5, 179.8)));
  EXPECT_FALSE(region.Meets(TileAt(-17.5, 0.0)));
}

TEST(GeoRegion, AHoleIsOutside) {
  const std::vector<LonLat> outline = {{8.0, 49.0}, {9.0, 49.0}, {9.0, 50.0}, {8.0, 50.0}};
  const std::vector<LonLat> hole = {{8.4, 49.4}, {8.6, 49.4}, {8.6, 49.6}, {8.4, 49.6}};
  const GeoRegion region = GeoRegion::OfPolygons({{outline, hole}});
  EXPECT_TRUE(region.Meets(TileAt(49.2, 8.5)));
  EXPECT_FALSE(region.Meets(TileAt(49.5, 8.5)));
  EXPECT_TRUE(region.Meets(TileAt(49.4, 8.5)));  // On the edge.
  EXPECT_FALSE(region.Meets(TileAt(50.5, 8.5)));
}

TEST(GeoRegion, ATriangleLeavesOutTheRestOfItsBox) {
  const GeoRegion region = GeoRegion::OfPolygons({{{{8.0, 49.0}, {9.0, 49.0}, {8.0, 50.0}}}});
  EXPECT_TRUE(region.Meets(TileAt(49.2, 8.2)));
  EXPECT_FALSE(region.Meets(TileAt(49.8, 8.8)));
}

TEST(GeoRegion, WhatIsNoRegionIsRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(ErrorCodeOf([] { GeoRegion::OfBox(50.0, 8.0, 49.0, 9.0); }), ErrorCode::kBadInput);
  EXPECT_EQ(ErrorCodeOf([] { GeoRegion::OfBox(49.0, 8.0, 91.0, 9.0); }), ErrorCode::kBadInput);
  EXPECT_EQ(ErrorCodeOf([&] { GeoRegion::OfBox(49.0, nan, 50.0, 9.0); }), ErrorCode::kBadInput);
  EXPECT_EQ(ErrorCodeOf([] { GeoRegion::OfPolygons({}); }), ErrorCode::kBadInput);
  EXPECT_EQ(ErrorCodeOf([] { GeoRegion::OfPolygons({{}}); }), ErrorCode::kBadInput);
  EXPECT_EQ(ErrorCodeOf([] {
              GeoRegion::OfPolygons({{{{8.0, 49.0}, {9.0, 49.0}}}});
            }),
            ErrorCode::kBadInput);
}

}  // namespace
}  // namespace cairn
