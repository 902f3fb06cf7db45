// Tests KeyframeMatcher.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <tuple>
#include <vector>

#include "engine/landmark_matches.h"
#include "engine/matching/match_features.h"
#include "engine/simple_tile.h"

namespace cairn {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::kDistanceTolerance;
using testing::LandmarkIds;
using testing::Match;
using testing::SimpleQuery;
using testing::SimpleTile;
using testing::SimpleView;

std::vector<Correspondence> MatchAgainst(const std::vector<KeyframeRef>& keyframes,
                                         const QueryContext& query,
                                         const std::vector<TileView>& tiles,
                                         double distance_quantile = 0.9) {
  const MatchingOptions options;
  return KeyframeMatcher(query, tiles, distance_quantile, options).Match(keyframes);
}

TEST(KeyframeMatcher, SeesOnlyWhatTheKeyframesSaw) {
  const std::vector<TileView> tiles = {
      SimpleView(SimpleTile({{1, {{0.0f}}}, {2, {{0.1f}}}, {3, {{0.2f}, {0.5f}}}, {4, {{0.3f}}}},
                            {{0, 2}, {2, 3}, {1}})),
      SimpleView(SimpleTile({{5, {{0.4f}}}, {6, {{0.0f}}}}, {{0}}))};
  const auto matches = MatchAgainst({{1, 0}, {0, 1}, {0, 0}, {0, 1}}, SimpleQuery({{0.0f}}), tiles);
  EXPECT_THAT(LandmarkIds(tiles, matches), ElementsAre(1, 3, 4, 5));
  EXPECT_NEAR(matches[1].sq_distance, 0.04f, kDistanceTolerance);
}

TEST(KeyframeMatcher, UsesTheQuantileGiven) {
  const std::vector<TileView> tiles = {
      SimpleView(SimpleTile({{1, {{0.4f}}}, {2, {{0.6f}}}}, {{0, 1}}))};
  EXPECT_EQ(MatchAgainst({{0, 0}}, SimpleQuery({{0.0f}}), tiles, 0.25).size(), 1u);
  EXPECT_EQ(MatchAgainst({{0, 0}}, SimpleQuery({{0.0f}}), tiles, 0.90).size(), 2u);
}

TEST(KeyframeMatcher, NoKeyframesOrTilesGiveNoMatches) {
  const std::vector<TileView> tiles = {SimpleView(SimpleTile({{1, {{0.4f}}}}, {{0}}))};
  EXPECT_THAT(MatchAgainst({}, SimpleQuery({{0.0f}}), tiles), IsEmpty());
  EXPECT_THAT(MatchAgainst({}, SimpleQuery({{0.0f}}), {}), IsEmpty());
}

TEST(KeyframeMatcher, OfAKeyframeThatSawAllEqualsMatchFeatures) {
  const std::vector<TileView> tiles = {SimpleView(SimpleTile(
      {{1, {{0.4f, 0.5}}}, {2, {{0.6f}, {0.9f, 1.0}}}, {3, {{1.5f, 2.0}}}}, {{0, 1, 2}}))};
  const QueryContext query = SimpleQuery({{0.5f, 1.0}, {1.0f}, {1.4f, -1.0}});
  const auto all = Match(query, tiles);
  const auto of_keyframe = MatchAgainst({{0, 0}}, query, tiles);
  ASSERT_EQ(all.size(), of_keyframe.size());
  for (size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(std::tie(all[i].keypoint_idx, all[i].landmark_idx, all[i].sq_distance),
              std::tie(of_keyframe[i].keypoint_idx, of_keyframe[i].landmark_idx,
                       of_keyframe[i].sq_distance));
  }
}

}  // namespace
}  // namespace cairn
