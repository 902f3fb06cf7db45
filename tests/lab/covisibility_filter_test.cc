#include "lab/rivals/covisibility_filter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "engine/keyframe_tile.h"

namespace cairn {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::MakeTile;
using testing::Match;
using testing::Range;
using ::testing::SizeIs;

std::vector<PoseCandidate> Filter(const std::vector<TileView>& tiles,
                                  const std::vector<Correspondence>& matches,
                                  const VotingOptions& options = {.min_score = 1.0}) {
  return CovisibilityCandidates(tiles, matches, options);
}

TEST(CovisibilityCandidates, AreTheConnectedComponentsLargestFirst) {
  // Two places: keyframes 0 and 1 share landmark 20, keyframe 2 sees none of theirs.
  const std::vector<TileView> tiles = {
      MakeTile(1, 60, {{0.0, Range(1, 20)}, {5.0, Range(20, 40)}, {60.0, Range(41, 60)}})};
  const std::vector<Correspondence> matches = {Match(0, 0, 45), Match(1, 0, 3),  Match(2, 0, 50),
                                               Match(3, 0, 19), Match(4, 0, 30), Match(5, 0, 51),
                                               Match(6, 0, 31)};
  const auto candidates = Filter(tiles, matches);
  ASSERT_THAT(candidates, SizeIs(2));
  EXPECT_THAT(candidates[0].correspondences, ElementsAre(1, 3, 4, 6));
  EXPECT_EQ(candidates[0].score, 4.0);
  EXPECT_THAT(candidates[1].correspondences, ElementsAre(0, 2, 5));
}

TEST(CovisibilityCandidates, AreConnectedByMatchedLandmarksOnly) {
  // As above, but nothing matched landmark 20.
  const std::vector<TileView> tiles = {
      MakeTile(1, 40, {{0.0, Range(1, 20)}, {5.0, Range(20, 40)}})};
  EXPECT_THAT(Filter(tiles, {Match(0, 0, 3), Match(1, 0, 4), Match(2, 0, 30)}), SizeIs(2));
}

TEST(CovisibilityCandidates, ReachAcrossTiles) {
  const std::vector<TileView> tiles = {MakeTile(1, 20, {{0.0, Range(1, 20)}}),
                                       MakeTile(20, 20, {{30.0, Range(20, 39)}})};
  // Landmark 20 stands in both tiles.
  const auto candidates = Filter(tiles, {Match(0, 0, 2), Match(1, 0, 19), Match(2, 1, 7)});
  ASSERT_THAT(candidates, SizeIs(1));
  EXPECT_THAT(candidates[0].correspondences, ElementsAre(0, 1, 2));
}

TEST(CovisibilityCandidates, CountAKeypointOnce) {
  const std::vector<TileView> tiles = {
      MakeTile(1, 40, {{0.0, Range(1, 20)}, {60.0, Range(21, 40)}})};
  const auto candidates = Filter(
      tiles, {Match(0, 0, 1), Match(0, 0, 2), Match(0, 0, 3), Match(1, 0, 30), Match(2, 0, 31)});
  ASSERT_THAT(candidates, SizeIs(2));
  EXPECT_THAT(candidates[0].correspondences, ElementsAre(3, 4));
  EXPECT_EQ(candidates[1].score, 1.0);
}

TEST(CovisibilityCandidates, RespectTheirNumberAndTheSmallestScore) {
  const std::vector<TileView> tiles = {
      MakeTile(1, 60, {{0.0, Range(1, 20)}, {30.0, Range(21, 40)}, {60.0, Range(41, 60)}})};
  const std::vector<Correspondence> matches = {Match(0, 0, 1),  Match(1, 0, 2),  Match(2, 0, 21),
                                               Match(3, 0, 22), Match(4, 0, 23), Match(5, 0, 41)};
  EXPECT_THAT(Filter(tiles, matches), SizeIs(3));
  EXPECT_THAT(Filter(tiles, matches, {.min_score = 2.0}), SizeIs(2));
  const auto largest = Filter(tiles, matches, {.max_candidates = 1, .min_score = 1.0});
  ASSERT_THAT(largest, SizeIs(1));
  EXPECT_THAT(largest[0].correspondences, ElementsAre(2, 3, 4));
}

TEST(CovisibilityCandidates, NothingFromNothing) {
  EXPECT_THAT(Filter({}, {}), IsEmpty());
  EXPECT_THAT(Filter({MakeTile(1, 20, {{0.0, Range(1, 20)}})}, {}), IsEmpty());
}

}  // namespace
}  // namespace cairn
