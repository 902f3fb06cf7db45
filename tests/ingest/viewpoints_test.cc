#include "ingest/tiles/viewpoints.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "support/tile_builder.h"

namespace cairn {
namespace {

// A tile with one keyframe for each session named, `step_m` apart, that all look the same way.
// Ids are 1, 2, ...
Tile Walk(const std::vector<int>& sessions, double step_m) {
  testing::RandomTileOptions options;
  options.num_keyframes = static_cast<int>(sessions.size());
  Tile tile = testing::RandomTile(options);
  for (size_t k = 0; k < sessions.size(); ++k) {
    tile.keyframes[k].session_id = SessionId(sessions[k]);
    tile.keyframes[k].cam_from_tile = {Eigen::Quaterniond::Identity(),
                                       {-step_m * static_cast<double>(k), 0.0, 0.0}};
  }
  return tile;
}

TEST(Viewpoints, KeepKeyframesOfTwoSessions) {
  EXPECT_THAT(ReplacedKeyframes(Walk({1, 2}, 0.5), {}), ::testing::IsEmpty());
  EXPECT_THAT(ReplacedKeyframes(Walk({1, 2, 3, 4}, 0.5), {}),
              ::testing::ElementsAre(KeyframeId(1), KeyframeId(2)));
  EXPECT_THAT(ReplacedKeyframes(Walk({1, 2, 3, 4}, 5.0), {}), ::testing::IsEmpty());
}

TEST(Viewpoints, KeepAllKeyframesOfTheNewestSession) {
  EXPECT_THAT(ReplacedKeyframes(Walk(std::vector<int>(40, 1), 0.01), {}), ::testing::IsEmpty());
}

TEST(Viewpoints, KeepTheLastKeyframesOfAnEarlierSession) {
  std::vector<int> sessions(40, 1);
  sessions.push_back(2);
  const std::vector<KeyframeId> replaced = ReplacedKeyframes(Walk(sessions, 0.01), {});
  ASSERT_EQ(replaced.size(), 24u);
  EXPECT_EQ(replaced.front(), KeyframeId(1));
  EXPECT_EQ(replaced.back(), KeyframeId(24));
}

TEST(Viewpoints, AnEarlierVideoKeepsKeyframesAlongItsWholeWay) {
  constexpr double kStepM = 0.1;
  std::vector<int> sessions(400, 1);
  sessions.push_back(2);
  const Tile tile = Walk(sessions, kStepM);
  const std::vector<KeyframeId> replaced = ReplacedKeyframes(tile, {});
  EXPECT_GT(replaced.size(), 100u);
  const std::set<KeyframeId> gone(replaced.begin(), replaced.end());
  for (int k = 0; k < 400; ++k) {
    int num_kept = 0;
    for (int other = std::max(0, k - 30); other <= std::min(399, k + 30); ++other) {
      num_kept += gone.contains(tile.keyframes[static_cast<size_t>(other)].id) ? 0 : 1;
    }
    EXPECT_GE(num_kept, 8) << k;
    EXPECT_LE(num_kept, 33) << k;
  }
}

}  // namespace
}  // namespace cairn
