#include "engine/tiles/landmark_keyframes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <vector>

#include "support/tile_builder.h"

namespace cairn {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// Checks every id from 0 to `last_id`.
void ExpectKeyframesOf(const Tile& tile, uint64_t last_id) {
  std::map<uint64_t, std::vector<uint32_t>> expected;
  for (uint32_t k = 0; k < tile.num_keyframes(); ++k) {
    for (const uint32_t landmark_idx : tile.LandmarksOfKeyframe(k)) {
      expected[Value(tile.landmark_ids[landmark_idx])].push_back(k);
    }
  }
  const LandmarkKeyframes landmark_keyframes(tile, tile);
  for (uint64_t id = 0; id <= last_id; ++id) {
    const auto keyframes = landmark_keyframes.KeyframesThatSaw(LandmarkId(id));
    EXPECT_EQ(std::vector(keyframes.begin(), keyframes.end()), expected[id]) << id;
  }
}

TEST(LandmarkKeyframes, AreTheTransposeOfCovisibility) {
  Tile tile = testing::RandomTile({.num_landmarks = 900,
                                   .num_keyframes = 40,
                                   .num_landmarks_per_keyframe = 100,
                                   .first_landmark_id = 50});
  ExpectKeyframesOf(tile, 1000);
  // Any order of ids, some far apart.
  std::mt19937_64 random(1);
  std::shuffle(tile.landmark_ids.begin(), tile.landmark_ids.end(), random);
  for (size_t i = 0; i < tile.landmark_ids.size(); i += 3) {
    tile.landmark_ids[i] = LandmarkId(Value(tile.landmark_ids[i]) << 40);
  }
  ExpectKeyframesOf(tile, 1000);
}

TEST(LandmarkKeyframes, ALandmarkThatNoKeyframeSawHasNone) {
  const Tile tile = testing::RandomTile({.num_landmarks = 5, .num_keyframes = 0});
  const LandmarkKeyframes landmark_keyframes(tile, tile);
  EXPECT_THAT(landmark_keyframes.KeyframesThatSaw(tile.landmark_ids[4]), IsEmpty());
}

TEST(LandmarkKeyframes, AnEmptyTileHasNone) {
  const Tile tile = testing::RandomTile({.num_landmarks = 0, .num_keyframes = 0});
  EXPECT_THAT(LandmarkKeyframes(tile, tile).KeyframesThatSaw(LandmarkId(1)), IsEmpty());
}

TEST(LandmarkKeyframes, OfTheLastLandmarkAndKeyframeAreThere) {
  Tile tile = testing::RandomTile({.num_landmarks = 3, .num_keyframes = 0});
  tile.landmark_ids = {LandmarkId(9), LandmarkId(7), LandmarkId(8)};
  tile.keyframes.resize(2);
  tile.keyframe_landmarks = {0, 2, 2};
  tile.keyframe_begin = {0, 2, 3};
  const LandmarkKeyframes landmark_keyframes(tile, tile);
  EXPECT_THAT(landmark_keyframes.KeyframesThatSaw(LandmarkId(9)), ElementsAre(0));
  EXPECT_THAT(landmark_keyframes.KeyframesThatSaw(LandmarkId(7)), IsEmpty());
  EXPECT_THAT(landmark_keyframes.KeyframesThatSaw(LandmarkId(8)), ElementsAre(0, 1));
}

// No sound tile has them, and none may keep a query waiting: not quadratic.
TEST(LandmarkKeyframes, OfManyLandmarksWithOneIdTheFirstIsFound) {
  constexpr int kNumLandmarks = 1'000'000;
  Tile tile;
  tile.landmark_ids.assign(kNumLandmarks, LandmarkId(3));
  tile.keyframes.resize(1);
  tile.keyframe_landmarks = {0, kNumLandmarks - 1};
  tile.keyframe_begin = {0, 2};
  const LandmarkKeyframes landmark_keyframes(tile, tile);
  EXPECT_THAT(landmark_keyframes.KeyframesThatSaw(LandmarkId(3)), ElementsAre(0));
}

}  // namespace
}  // namespace cairn
