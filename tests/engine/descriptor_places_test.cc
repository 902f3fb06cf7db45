#include "engine/tiles/descriptor_places.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "support/tile_builder.h"

namespace cairn {
namespace {

using ::cairn::testing::RandomTile;

uint32_t LandmarkOf(const Tile& tile, uint32_t descriptor) {
  const auto after =
      std::upper_bound(tile.descriptor_begin.begin(), tile.descriptor_begin.end(), descriptor);
  return static_cast<uint32_t>(after - tile.descriptor_begin.begin()) - 1;
}

std::vector<uint32_t> TileOrder(const Tile& tile) {
  std::vector<uint32_t> order(tile.num_descriptors());
  std::iota(order.begin(), order.end(), 0u);
  return order;
}

std::vector<uint32_t> ShuffledOrder(const Tile& tile) {
  std::vector<uint32_t> order = TileOrder(tile);
  std::shuffle(order.begin(), order.end(), std::mt19937(7));
  return order;
}

void ExpectPlaces(const Tile& tile, const DescriptorPlaces& places,
                  const std::vector<uint32_t>& order) {
  ASSERT_EQ(places.size(), order.size());
  for (size_t place = 0; place < order.size(); ++place) {
    const uint32_t landmark = LandmarkOf(tile, order[place]);
    ASSERT_EQ(places.descriptor(place), order[place]);
    ASSERT_EQ(places.landmark(place), landmark);
    ASSERT_EQ(places.orientation_code(place), tile.orientation_codes[order[place]]);
    // To the nearest point of the grid, but for rounding.
    const Eigen::Vector2f xy =
        places.grid().corner() + places.grid().step_m() * places.CoarseXy(place);
    ASSERT_LE((xy - tile.x_in_tile[landmark].head<2>()).cwiseAbs().maxCoeff(),
              0.501f * places.grid().step_m() + 1e-4f);
    ASSERT_LE(std::abs(tile.x_in_tile[landmark].z()), places.grid().max_height_m());
  }
}

TEST(DescriptorPlaces, FollowTheOrderOfTheIndex) {
  const Tile tile = RandomTile({.num_landmarks = 500});
  const std::vector<uint32_t> order = ShuffledOrder(tile);
  ExpectPlaces(tile, DescriptorPlaces(tile, order), order);
}

TEST(DescriptorPlaces, FollowTheTileWithoutAnOrder) {
  const Tile tile = RandomTile({.num_landmarks = 500});
  ExpectPlaces(tile, DescriptorPlaces(tile, {}), TileOrder(tile));
}

TEST(DescriptorPlaces, MayBeThoseOfSomeDescriptors) {
  const Tile tile = RandomTile({.num_landmarks = 500});
  std::vector<uint32_t> some = ShuffledOrder(tile);
  some.resize(100);
  LargeVector<uint32_t> landmarks;
  for (const uint32_t descriptor : some) {
    landmarks.push_back(LandmarkOf(tile, descriptor));
  }
  ExpectPlaces(tile, DescriptorPlaces(tile, CoarseGrid(tile), some, landmarks), some);
}

TEST(DescriptorPlaces, StandALandmarkAtTheEdgeOfTheTileFrame) {
  Tile tile = RandomTile({.num_landmarks = 500});
  tile.x_in_tile.front() = Eigen::Vector3f(-4096.0f, 4095.99609375f, -4096.0f);
  const std::vector<uint32_t> order = ShuffledOrder(tile);
  ExpectPlaces(tile, DescriptorPlaces(tile, order), order);
}

TEST(DescriptorPlaces, StandOneLandmarkAndNone) {
  const Tile one = RandomTile({.num_landmarks = 1});
  ExpectPlaces(one, DescriptorPlaces(one, {}), TileOrder(one));
  EXPECT_EQ(DescriptorPlaces(Tile(), {}).size(), 0u);
}

}  // namespace
}  // namespace cairn
