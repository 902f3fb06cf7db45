// The terms and filters of matching: orientations and positions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/angles.h"
#include "engine/landmark_matches.h"
#include "engine/matching/match_features.h"
#include "engine/simple_tile.h"

namespace cairn {
namespace {

using ::testing::ElementsAre;
using testing::kDistanceTolerance;
using testing::LandmarkIds;
using testing::Match;
using testing::SimpleQuery;
using testing::SimpleTile;
using testing::SimpleView;

MatchingOptions WithoutTerms() { return {.orientation_weight = 0.0, .position_weight = 0.0}; }

TEST(MatchFilters, PriorTermsDoNotMoveTheThreshold) {
  const std::vector<TileView> tiles = {SimpleView(SimpleTile({{1, {{0.4f, 0.0}}}}))};
  MatchingOptions options;
  options.distance_quantile = 0.25;
  options.orientation_weight = 100.0;
  const auto matches = Match(SimpleQuery({{0.0f, kPi}}), tiles, options);
  ASSERT_EQ(matches.size(), 1u);
  EXPECT_NEAR(matches[0].sq_distance, 0.16f + 400.0f, 0.1f);
}

TEST(MatchFilters, OrientationTermPrefersTheAlignedLandmark) {
  const std::vector<TileView> tiles = {
      SimpleView(SimpleTile({{1, {{0.3f, 2.0}}}, {2, {{0.4f, 0.0}}}, {3, {{0.5f}}}}))};
  MatchingOptions options;
  options.orientation_weight = 0.2;
  const auto matches = Match(SimpleQuery({{0.0f, 0.0}}), tiles, options);
  // 0.16 + 0, 0.25 without an orientation, 0.09 + 0.2 (2 - 2 cos 2).
  EXPECT_THAT(LandmarkIds(tiles, matches), ElementsAre(2, 3, 1));
  EXPECT_NEAR(matches[2].sq_distance, 0.09 + 0.2 * (2.0 - 2.0 * std::cos(2.0)), kDistanceTolerance);
}

TEST(MatchFilters, OrientationsWrapAround) {
  const std::vector<TileView> tiles = {SimpleView(SimpleTile({{1, {{0.0f, kPi - 0.05}}}}))};
  MatchingOptions options;
  options.orientation_weight = 1.0;
  options.max_orientation_difference_rad = 0.2;
  const auto matches = Match(SimpleQuery({{0.0f, -kPi + 0.05}}), tiles, options);
  ASSERT_EQ(matches.size(), 1u);
  EXPECT_LT(matches[0].sq_distance, 0.025f);  // 0.1 rad, and half a step of the codes.
}

TEST(MatchFilters, HardFilterRejectsOtherOrientationsAndPassesUnknownOnes) {
  const std::vector<TileView> tiles = {SimpleView(
      SimpleTile({{1, {{0.1f, 1.2}}}, {2, {{0.2f, 0.8}}}, {3, {{0.3f}}}, {4, {{0.4f, -2.0}}}}))};
  MatchingOptions options = WithoutTerms();
  options.max_orientation_difference_rad = 1.0;
  EXPECT_THAT(LandmarkIds(tiles, Match(SimpleQuery({{0.0f, 0.0}}), tiles, options)),
              ElementsAre(2, 3));
  EXPECT_THAT(LandmarkIds(tiles, Match(SimpleQuery({{0.0f}}), tiles, options)),
              ElementsAre(1, 2, 3, 4));
}

TEST(MatchFilters, HardFilterOffAcceptsOppositeOrientations) {
  const std::vector<TileView> tiles = {SimpleView(SimpleTile({{1, {{0.0f, kPi}}}}))};
  EXPECT_EQ(Match(SimpleQuery({{0.0f, 0.0}}), tiles).size(), 1u);
}

TEST(MatchFilters, PositionTermPrefersLandmarksInView) {
  const std::vector<TileView> tiles = {
      SimpleView(SimpleTile({{1, {{0.3f}}, {80.0, 0.0, 0.0}}, {2, {{0.4f}}, {40.0, 0.0, 0.0}}}))};
  QueryContext query = SimpleQuery({{0.0f}});
  query.region.prior_xy_in_anchor = {0.0, 0.0};
  query.region.prior_sigma_m = 10.0;
  MatchingOptions options{.position_weight = 0.02, .viewing_distance_m = 50.0};
  EXPECT_THAT(LandmarkIds(tiles, Match(query, tiles, options)), ElementsAre(1, 2));
  query.region.has_prior = true;
  const auto matches = Match(query, tiles, options);
  EXPECT_THAT(LandmarkIds(tiles, matches), ElementsAre(2, 1));
  EXPECT_NEAR(matches[0].sq_distance, 0.16, kDistanceTolerance);
  EXPECT_NEAR(matches[1].sq_distance, 0.09 + 0.02 * 9.0, kDistanceTolerance);
}

TEST(MatchFilters, HardPositionFilterRejectsLandmarksOutOfView) {
  const std::vector<TileView> tiles = {
      SimpleView(SimpleTile({{1, {{0.3f}}, {80.0, 0.0, 0.0}}, {2, {{0.4f}}, {65.0, 0.0, 9.0}}}))};
  QueryContext query = SimpleQuery({{0.0f}});
  query.region.prior_sigma_m = 10.0;
  MatchingOptions options = WithoutTerms();
  options.viewing_distance_m = 50.0;
  options.max_position_excess_sigmas = 2.0;
  EXPECT_THAT(LandmarkIds(tiles, Match(query, tiles, options)), ElementsAre(1, 2));
  query.region.has_prior = true;
  const auto matches = Match(query, tiles, options);
  EXPECT_THAT(LandmarkIds(tiles, matches), ElementsAre(2));
  EXPECT_NEAR(matches[0].sq_distance, 0.16, kDistanceTolerance);  // No term without a weight.
}

}  // namespace
}  // namespace cairn
