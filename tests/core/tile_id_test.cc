#include "core/tile_id.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/error.h"

namespace cairn {
namespace {

TEST(TileId, PrintsZoneHemisphereAndIndices) {
  // Zurich main station, UTM 32N 465152 5247094.
  const TileId id = TileId::Containing(Geodetic::FromDegrees(47.3769, 8.5417, 400.0));
  EXPECT_EQ(id.ToString().substr(0, 4), "32N-");
  EXPECT_EQ(TileId::Parse(id.ToString()), id);
  EXPECT_EQ(TileId::FromValue(id.value()), id);
}

TEST(TileId, AnchorIsTheCenter) {
  for (const auto& position :
       {Geodetic::FromDegrees(47.3769, 8.5417, 400.0), Geodetic::FromDegrees(-33.8, 151.2, 0.0),
        Geodetic::FromDegrees(89.0, 20.0, 0.0), Geodetic::FromDegrees(-88.0, -120.0, 0.0)}) {
    const TileId id = TileId::Containing(position);
    EXPECT_EQ(TileId::Containing(id.Anchor()), id);
    EXPECT_LT(GroundDistanceM(id.Anchor(), {position.lat_rad, position.lon_rad, 0.0}), 110.0);
    EXPECT_DOUBLE_EQ(id.Anchor().h_m, 0.0);
  }
}

TEST(TileId, CornersAreASideApart) {
  const TileId id = TileId::Containing(Geodetic::FromDegrees(47.3769, 8.5417, 400.0));
  const auto corners = id.Corners();
  ASSERT_EQ(corners.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(GroundDistanceM(corners[i], corners[(i + 1) % 4]), TileId::kSideM, 0.2);
  }
  EXPECT_GT(corners[1].lon_rad, corners[0].lon_rad);  // South-west, then south-east.
  EXPECT_GT(corners[2].lat_rad, corners[1].lat_rad);
}

TEST(TileId, BoundsHoldTheCorners) {
  const TileId id = TileId::Containing(Geodetic::FromDegrees(60.1, 24.9, 10.0));
  const GeoBox box = id.Bounds();
  for (const Geodetic& corner : id.Corners()) {
    EXPECT_GE(corner.lat_rad, box.south_rad);
    EXPECT_LE(corner.lat_rad, box.north_rad);
    EXPECT_GE(corner.lon_rad, box.west_rad);
    EXPECT_LE(corner.lon_rad, box.east_rad);
  }
}

TEST(TileId, BothSidesOfAZoneBorderHaveTiles) {
  const TileId west = TileId::Containing(Geodetic::FromDegrees(47.0, 11.9999, 0.0));
  const TileId east = TileId::Containing(Geodetic::FromDegrees(47.0, 12.0001, 0.0));
  EXPECT_EQ(west.zone(), 32);
  EXPECT_EQ(east.zone(), 33);
}

TEST(TileId, FieldsSurviveThePacking) {
  const TileId id = TileId::Parse("32N-03104-35120");
  EXPECT_EQ(id.zone(), 32);
  EXPECT_TRUE(id.north());
  EXPECT_EQ(id.easting_idx(), 3104);
  EXPECT_EQ(id.northing_idx(), 35120);
  EXPECT_EQ(id.ToString(), "32N-03104-35120");
}

TEST(TileId, RefusesWhatIsNoTile) {
  for (const char* text : {"", "32N", "32X-03104-35120", "61N-03104-35120", "32N-03104-3512a",
                           "32N-03104-351200", "32N+03104-35120", "32N-99999-35120"}) {
    EXPECT_THROW(TileId::Parse(text), Error) << text;
  }
  EXPECT_THROW(TileId::FromValue(~uint64_t{0}), Error);
}

TEST(TileId, ContainingRefusesPositionsOffTheEarth) {
  EXPECT_THROW(TileId::Containing(Geodetic::FromDegrees(95.0, 0.0, 0.0)), Error);
  EXPECT_THROW(TileId::Containing(Geodetic::FromDegrees(std::nan(""), 0.0, 0.0)), Error);
}

TEST(TileId, WithIndicesKeepsTheZone) {
  for (const char* name : {"32N-03104-35120", "56S-00001-67108", "00N-13333-13334"}) {
    const TileId id = TileId::Parse(name);
    EXPECT_EQ(id.WithIndices(id.easting_idx(), id.northing_idx()), id);
    EXPECT_EQ(id.WithIndices(7, 9).ToString().substr(0, 3), std::string(name).substr(0, 3));
    EXPECT_EQ(id.WithIndices(7, 9).ToString().substr(3), "-00007-00009");
  }
}

}  // namespace
}  // namespace cairn
