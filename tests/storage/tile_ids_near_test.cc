#include "storage/map/internal/tile_ids_near.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "core/angles.h"
#include "core/tile_id.h"
#include "storage/inspection/geo_box.h"

namespace cairn {
namespace {

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

// Returns false if the box has no ids.
bool ExpectIdsOfWhatMeets(const Geodetic& center, double radius_m) {
  const GeoBox box = BoxAround(center, radius_m);
  const std::optional<std::vector<int64_t>> ids = TileIdsNear(box);
  if (!ids) {
    return false;
  }
  for (const TileId tile : TilesAround(center, radius_m)) {
    if (BoxesMeet(tile.Bounds(), box)) {
      EXPECT_TRUE(std::binary_search(ids->begin(), ids->end(), static_cast<int64_t>(tile.value())))
          << tile.ToString();
    }
  }
  return true;
}

TEST(TileIdsNear, HaveEveryTileThatMeetsTheBox) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> lat_deg(-79.0, 79.0), lon_deg(-180.0, 180.0),
      radius_m(1.0, 1500.0);
  int num_with_ids = 0;
  for (int i = 0; i < 100; ++i) {
    num_with_ids += ExpectIdsOfWhatMeets(
        Geodetic::FromDegrees(lat_deg(random), lon_deg(random), 0.0), radius_m(random));
  }
  EXPECT_GE(num_with_ids, 90);
}

// There, the grid is turned most, and parallels bend most.
TEST(TileIdsNear, HaveEveryTileOfLargeBoxesInTheNorth) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> lat_deg(70.0, 79.9), lon_deg(0.0, 42.0);
  int num_with_ids = 0;
  for (int i = 0; i < 20; ++i) {
    num_with_ids +=
        ExpectIdsOfWhatMeets(Geodetic::FromDegrees(lat_deg(random), lon_deg(random), 0.0), 4'100.0);
  }
  EXPECT_GE(num_with_ids, 15);
  for (const double border_deg :
       {9.1, 20.9, 21.1, 32.9}) {  // Near the borders of zones of 12 degrees.
    ExpectIdsOfWhatMeets(Geodetic::FromDegrees(79.0, border_deg, 0.0), 300.0);
  }
}

// Tiles reach into the next zone, by up to their diagonal.
TEST(TileIdsNear, HaveEveryTileThatReachesOverABorder) {
  int num_with_ids = 0;
  for (double off_m = -400.0; off_m <= 400.0; off_m += 20.0) {
    const double north_deg = off_m / 111'000.0;
    for (const auto& [lat_deg, lon_deg] : {std::pair{48.0, 12.0},
                                           {60.0, 3.0},
                                           {64.0, 6.0},
                                           {79.0, 9.0},
                                           {79.0, 21.0},
                                           {1.0, 12.0}}) {
      const double east_deg = north_deg / std::cos(lat_deg / kDegPerRad);
      num_with_ids +=
          ExpectIdsOfWhatMeets(Geodetic::FromDegrees(lat_deg, lon_deg + east_deg, 0.0), 100.0);
    }
    for (const auto& [lat_deg, lon_deg] :
         {std::pair{0.0, 9.0}, {56.0, 4.0}, {64.0, 4.0}, {72.0, 10.0}}) {
      num_with_ids +=
          ExpectIdsOfWhatMeets(Geodetic::FromDegrees(lat_deg + north_deg, lon_deg, 0.0), 100.0);
    }
  }
  EXPECT_GE(num_with_ids, 100);  // Of 410; the others are near the border.
}

TEST(TileIdsNear, HaveEveryTileNearBordersOfZones) {
  for (const double off_deg : {-0.02, -0.003, -0.0005, 0.0, 0.0005, 0.003, 0.02}) {
    ExpectIdsOfWhatMeets(Geodetic::FromDegrees(48.0, 12.0 + off_deg, 0.0), 400.0);
    ExpectIdsOfWhatMeets(Geodetic::FromDegrees(off_deg, 9.0, 0.0), 400.0);
    ExpectIdsOfWhatMeets(Geodetic::FromDegrees(60.0, 3.0 + off_deg, 0.0), 400.0);
    ExpectIdsOfWhatMeets(Geodetic::FromDegrees(64.0 + off_deg, 3.0 + off_deg, 0.0), 400.0);
  }
}

TEST(TileIdsNear, AreFewForThePriorOfAPhone) {
  const auto ids = TileIdsNear(BoxAround(Geodetic::FromDegrees(49.0, 8.4, 0.0), 100.0));
  ASSERT_TRUE(ids.has_value());
  EXPECT_LE(ids->size(), 9u);
  EXPECT_TRUE(std::is_sorted(ids->begin(), ids->end()));
}

TEST(TileIdsNear, AreNotForLargeBoxesPolesAndTheAntimeridian) {
  EXPECT_FALSE(TileIdsNear(BoxAround(Geodetic::FromDegrees(49.0, 8.4, 0.0), 50'000.0)));
  EXPECT_FALSE(TileIdsNear(BoxAround(Geodetic::FromDegrees(89.0, 8.4, 0.0), 100.0)));
  for (const double lon_deg : {180.0, 179.9985, -179.9985, 179.9978, -179.9978}) {
    EXPECT_FALSE(TileIdsNear(BoxAround(Geodetic::FromDegrees(-17.0, lon_deg, 0.0), 100.0)));
  }
}

}  // namespace
}  // namespace cairn
