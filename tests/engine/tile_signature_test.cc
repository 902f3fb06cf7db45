#include "engine/places/tile_signature.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "support/tile_builder.h"

namespace cairn {
namespace {

TEST(PlaceCells, AreRowsFromTheSouthWest) {
  EXPECT_EQ(PlaceCells::Containing({-74.9, -74.9}), 0);
  EXPECT_EQ(PlaceCells::Containing({74.9, -74.9}), PlaceCells::kPerSide - 1);
  EXPECT_EQ(PlaceCells::Containing({-74.9, 74.9}), PlaceCells::kPerTile - PlaceCells::kPerSide);
  EXPECT_EQ(PlaceCells::Containing({1e9, 1e9}), PlaceCells::kPerTile - 1);
}

TEST(TileSignature, HoldsEachDescriptorOnce) {
  const Tile tile = testing::RandomTile({.num_landmarks = 300, .num_keyframes = 20});
  const TileSignature all = MakeTileSignature(tile, 100'000);
  ASSERT_EQ(all.size(), tile.num_descriptors());
  const auto rows = [](const std::vector<uint8_t>& codes) {
    std::multiset<std::vector<uint8_t>> sorted;
    for (auto row = codes.begin(); row != codes.end(); row += 8) {
      sorted.emplace(row, row + 8);
    }
    return sorted;
  };
  EXPECT_EQ(rows(all.codes), rows(tile.codes));
}

TEST(TileSignature, AShorterOneIsAPrefixSpreadOverTheTile) {
  Tile tile = testing::RandomTile({.num_landmarks = 256, .max_descriptors_per_landmark = 1});
  for (size_t i = 0; i < tile.num_landmarks(); ++i) {  // The code is the landmark's number.
    tile.codes[8 * i] = static_cast<uint8_t>(i);
  }
  const TileSignature all = MakeTileSignature(tile, 100'000), some = MakeTileSignature(tile, 64);
  ASSERT_EQ(some.size(), 64u);
  EXPECT_TRUE(std::equal(some.codes.begin(), some.codes.end(), all.codes.begin()));
  std::vector<int> counts(4, 0);
  for (size_t i = 0; i < some.size(); ++i) {
    ++counts[some.codes[8 * i] / 64];
  }
  EXPECT_EQ(counts, std::vector<int>(4, 16));
}

TEST(TileSignature, TheCellIsThatOfTheCameras) {
  Tile tile = testing::RandomTile({.num_landmarks = 1, .num_keyframes = 2});
  const double east_m[] = {0.0, 20.0};
  for (int k = 0; k < 2; ++k) {
    tile.keyframes[k].cam_from_tile =
        Rigid3d(Eigen::Quaterniond::Identity(), Eigen::Vector3d(-east_m[k], 0.0, 0.0));
  }
  const TileSignature signature = MakeTileSignature(tile, 10);
  ASSERT_GE(signature.size(), 1u);
  EXPECT_EQ(signature.traits.front().cell, PlaceCells::Containing(Eigen::Vector2d(10.0, 0.0)));
  EXPECT_EQ(signature.traits.front().azimuth_code, tile.azimuth_codes.front());
  EXPECT_EQ(signature.traits.front().orientation_code, tile.orientation_codes.front());
}

TEST(TileSignature, OfATileWithoutKeyframesHoldsAllLandmarks) {
  Tile tile = testing::RandomTile();
  tile.keyframes.clear();
  tile.keyframe_begin = {0};
  tile.keyframe_landmarks.clear();
  EXPECT_EQ(MakeTileSignature(tile, 100'000).size(), tile.num_descriptors());
}

}  // namespace
}  // namespace cairn
