#include "storage/map/tile_cells.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/angles.h"
#include "storage/geometry/geo_box.h"

namespace cairn {
namespace {

using ::testing::Contains;

// Returns the tiles at a lattice of points in and around the box.
std::vector<TileId> TilesAround(const Geodetic& center, double radius_m) {
  const Rigid3d ecef_from_enu = EcefFromEnu(center);
  std::vector<TileId> tiles;
  for (double x_m = -radius_m - 300.0; x_m <= radius_m + 300.0; x_m += 50.0) {
    for (double y_m = -radius_m - 300.0; y_m <= radius_m + 300.0; y_m += 50.0) {
      tiles.push_back(
          TileId::Containing(GeodeticFromEcef(ecef_from_enu * Eigen::Vector3d(x_m, y_m, 0.0))));
    }
  }
  std::sort(tiles.begin(), tiles.end());
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
  return tiles;
}

void ExpectCellsHoldWhatMeets(const Geodetic& center, double radius_m) {
  const GeoBox box = BoxAround(center, radius_m);
  const std::optional<std::vector<TileCell>> cells = CellsMeeting(box);
  if (!cells) {
    return;
  }
  for (const TileId tile : TilesAround(center, radius_m)) {
    if (BoxesMeet(tile.Bounds(), box)) {
      EXPECT_THAT(*cells, Contains(CellOf(tile))) << tile.ToString();
    }
  }
}

TEST(TileCells, HoldEveryTileThatMeetsTheBox) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> lat_deg(-79.0, 79.0), lon_deg(-180.0, 180.0),
      radius_m(1.0, 1500.0);
  for (int i = 0; i < 100; ++i) {
    ExpectCellsHoldWhatMeets(Geodetic::FromDegrees(lat_deg(random), lon_deg(random), 0.0),
                             radius_m(random));
  }
}

TEST(TileCells, HoldEveryTileNearBordersOfZones) {
  for (const double off_deg : {-0.02, -0.003, -0.0005, 0.0, 0.0005, 0.003, 0.02}) {
    ExpectCellsHoldWhatMeets(Geodetic::FromDegrees(48.0, 12.0 + off_deg, 0.0), 400.0);
    ExpectCellsHoldWhatMeets(Geodetic::FromDegrees(off_deg, 9.0, 0.0), 400.0);
    ExpectCellsHoldWhatMeets(Geodetic::FromDegrees(60.0, 3.0 + off_deg, 0.0), 400.0);
    ExpectCellsHoldWhatMeets(Geodetic::FromDegrees(64.0 + off_deg, 3.0 + off_deg, 0.0), 400.0);
  }
}

TEST(TileCells, AreFewForThePriorOfAPhone) {
  const auto cells = CellsMeeting(BoxAround(Geodetic::FromDegrees(49.0, 8.4, 0.0), 100.0));
  ASSERT_TRUE(cells.has_value());
  EXPECT_LE(cells->size(), 4u);
}

TEST(TileCells, AreNotForLargeBoxesAndPoles) {
  EXPECT_FALSE(CellsMeeting(BoxAround(Geodetic::FromDegrees(49.0, 8.4, 0.0), 50'000.0)));
  EXPECT_FALSE(CellsMeeting(BoxAround(Geodetic::FromDegrees(89.0, 8.4, 0.0), 100.0)));
  EXPECT_FALSE(CellsMeeting(BoxAround(Geodetic::FromDegrees(-17.0, 180.0, 0.0), 100.0)));
}

TEST(TileCells, HaveRangesOfTheirTiles) {
  const TileId tile = TileId::Containing(Geodetic::FromDegrees(49.0, 8.4, 0.0));
  const auto ranges = TileRanges(CellOf(tile));
  EXPECT_EQ(ranges.size(), 4u);
  EXPECT_TRUE(std::any_of(ranges.begin(), ranges.end(), [&](const auto& range) {
    const auto id = static_cast<int64_t>(tile.value());
    return range.first <= id && id <= range.second;
  }));
}

}  // namespace
}  // namespace cairn
