#include "engine/refinement/rank_keyframes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "core/error.h"
#include "engine/keyframe_tile.h"

namespace cairn {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::MakeTile;
using testing::Match;
using testing::Range;
using ::testing::SizeIs;

QueryContext MakeQuery(int num_keypoints) {
  QueryContext query;
  query.keypoints.resize(num_keypoints);
  return query;
}

TEST(RankKeyframes, ScoresByChernoffBoundOfBinomialTail) {
  // 20 observations each; 6 of 8 keypoints match what keyframe 1 saw, 2 what keyframe 0 saw.
  const std::vector<TileView> tiles = {
      MakeTile(1, 60, {{0.0, Range(1, 20)}, {30.0, Range(21, 40)}, {60.0, Range(41, 60)}})};
  std::vector<Correspondence> matches = {Match(0, 0, 0), Match(1, 0, 1)};
  for (int i = 2; i < 8; ++i) {
    matches.push_back(Match(i, 0, 20 + i));
  }
  const auto ranked = RankKeyframes(MakeQuery(8), tiles, matches, RefinementOptions());
  ASSERT_THAT(ranked, SizeIs(1));  // 2 of 8 is less than a third.
  EXPECT_EQ(ranked[0].keyframe.keyframe_idx, 1u);
  EXPECT_EQ(ranked[0].num_votes, 6);
  const double expected =
      8.0 * (0.75 * std::log(0.75 / (1.0 / 3.0)) + 0.25 * std::log(0.25 / (2.0 / 3.0)));
  EXPECT_NEAR(ranked[0].log_score, expected, 1e-12);
}

TEST(RankKeyframes, KeyframeWithManyObservationsNeedsManyVotes) {
  // Equal votes: the keyframe that saw less is less likely to have them by chance.
  const std::vector<TileView> tiles = {
      MakeTile(1, 200, {{0.0, Range(1, 90)}, {30.0, Range(91, 100)}, {60.0, Range(101, 200)}})};
  std::vector<Correspondence> matches;
  for (int i = 0; i < 5; ++i) {
    matches.push_back(Match(2 * i, 0, i));
    matches.push_back(Match(2 * i + 1, 0, 90 + i));
  }
  const auto ranked = RankKeyframes(MakeQuery(10), tiles, matches, RefinementOptions());
  ASSERT_THAT(ranked, SizeIs(2));
  EXPECT_EQ(ranked[0].keyframe.keyframe_idx, 1u);
  EXPECT_EQ(ranked[1].keyframe.keyframe_idx, 0u);
}

TEST(RankKeyframes, KeypointVotesOncePerKeyframe) {
  const std::vector<TileView> tiles = {
      MakeTile(1, 40, {{0.0, Range(1, 20)}, {30.0, Range(21, 40)}})};
  const std::vector<Correspondence> matches = {Match(0, 0, 0), Match(0, 0, 1), Match(0, 0, 2),
                                               Match(1, 0, 3)};
  const auto ranked = RankKeyframes(MakeQuery(2), tiles, matches, RefinementOptions());
  ASSERT_THAT(ranked, SizeIs(1));
  EXPECT_EQ(ranked[0].num_votes, 2);
}

TEST(RankKeyframes, RecognizesLandmarkOfNeighboringTile) {
  // The match names the copy in tile 0; the keyframe that saw it stands in tile 1.
  const std::vector<TileView> tiles = {MakeTile(1, 20, {{0.0, Range(1, 10)}}),
                                       MakeTile(11, 20, {{30.0, Range(11, 30)}})};
  const std::vector<Correspondence> matches = {Match(0, 0, 12), Match(1, 0, 13)};
  const auto ranked = RankKeyframes(MakeQuery(2), tiles, matches, RefinementOptions());
  ASSERT_THAT(ranked, SizeIs(1));
  EXPECT_EQ(ranked[0].keyframe.tile_idx, 1);
  EXPECT_EQ(ranked[0].num_votes, 2);
}

TEST(RankKeyframes, PriorDecidesBetweenEqualVotes) {
  const std::vector<TileView> tiles = {
      MakeTile(1, 60, {{0.0, Range(1, 20)}, {40.0, Range(21, 40)}, {20.0, Range(41, 60)}})};
  QueryContext query = MakeQuery(8);
  query.region.has_prior = true;
  query.region.prior_sigma_m = 10.0;
  query.region.prior_xy_in_anchor = {35.0, 0.0};
  std::vector<Correspondence> matches;
  for (int i = 0; i < 4; ++i) {
    matches.push_back(Match(i, 0, i));
    matches.push_back(Match(4 + i, 0, 20 + i));
  }
  const auto ranked = RankKeyframes(query, tiles, matches, RefinementOptions());
  ASSERT_THAT(ranked, SizeIs(2));
  EXPECT_EQ(ranked[0].keyframe.keyframe_idx, 1u);
  EXPECT_NEAR(ranked[0].log_score - ranked[1].log_score, (35.0 * 35.0 - 5.0 * 5.0) / 200.0, 1e-9);
}

TEST(RankKeyframes, KeepsBestOfEachLocation) {
  const std::vector<TileView> tiles = {MakeTile(
      1, 100,
      {{0.0, Range(1, 20)}, {1.0, Range(5, 24)}, {50.0, Range(41, 60)}, {90.0, Range(61, 100)}})};
  std::vector<Correspondence> matches;
  for (int i = 0; i < 12; ++i) {
    matches.push_back(Match(i, 0, i + 3));
  }
  RefinementOptions options;
  const auto ranked = RankKeyframes(MakeQuery(12), tiles, matches, options);
  ASSERT_THAT(ranked, SizeIs(1));
  EXPECT_EQ(ranked[0].keyframe.keyframe_idx, 0u);
  options.min_separation_m = 0.5;
  EXPECT_THAT(RankKeyframes(MakeQuery(12), tiles, matches, options), SizeIs(2));
}

TEST(RankKeyframes, ObeysLimit) {
  const std::vector<TileView> tiles = {
      MakeTile(1, 60, {{0.0, Range(1, 20)}, {30.0, Range(21, 40)}, {60.0, Range(41, 60)}})};
  RefinementOptions options;
  options.max_keyframes = 1;
  const std::vector<Correspondence> matches = {Match(0, 0, 0), Match(1, 0, 20), Match(2, 0, 21)};
  EXPECT_THAT(RankKeyframes(MakeQuery(3), tiles, matches, options), SizeIs(1));
}

TEST(RankKeyframes, NothingWithoutMatchesTilesOrContrast) {
  const std::vector<TileView> tiles = {MakeTile(1, 20, {{0.0, Range(1, 20)}})};
  EXPECT_THAT(RankKeyframes(MakeQuery(1), tiles, {}, RefinementOptions()), IsEmpty());
  EXPECT_THAT(RankKeyframes(MakeQuery(1), {}, {}, RefinementOptions()), IsEmpty());
  // The only keyframe has exactly its share.
  EXPECT_THAT(RankKeyframes(MakeQuery(1), tiles, {Match(0, 0, 0)}, RefinementOptions()), IsEmpty());
}

std::vector<std::pair<int, uint32_t>> Pairs(const std::vector<KeyframeRef>& refs) {
  std::vector<std::pair<int, uint32_t>> pairs;
  for (const KeyframeRef& ref : refs) {
    pairs.emplace_back(ref.tile_idx, ref.keyframe_idx);
  }
  return pairs;
}

TEST(KeyframeNeighborhood, MostSharedFirstAcrossTiles) {
  const std::vector<TileView> tiles = {
      MakeTile(1, 40, {{0.0, Range(1, 20)}, {5.0, Range(16, 30)}, {10.0, Range(31, 40)}}),
      MakeTile(5, 30, {{20.0, Range(11, 30)}})};
  using Pair = std::pair<int, uint32_t>;
  EXPECT_THAT(Pairs(KeyframeNeighborhood(tiles, {0, 0}, 4)),
              ElementsAre(Pair(0, 0), Pair(1, 0), Pair(0, 1)));
  EXPECT_THAT(Pairs(KeyframeNeighborhood(tiles, {0, 0}, 1)), ElementsAre(Pair(0, 0), Pair(1, 0)));
  EXPECT_THAT(Pairs(KeyframeNeighborhood(tiles, {0, 0}, 0)), ElementsAre(Pair(0, 0)));
}

TEST(KeyframeNeighborhood, LeavesOutFarKeyframes) {
  const std::vector<TileView> tiles = {
      MakeTile(1, 20, {{0.0, Range(1, 20)}, {60.0, Range(1, 20)}})};
  EXPECT_THAT(KeyframeNeighborhood(tiles, {0, 0}, 4), SizeIs(1));
}

TEST(RefinementOptions, RejectsNonsenseNamingTheField) {
  RefinementOptions options;
  EXPECT_NO_THROW(options.Validate());
  options.min_separation_m = -1.0;
  try {
    options.Validate();
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("min_separation_m"));
  }
}

}  // namespace
}  // namespace cairn
