// How far a session may move, turn and grow to follow the map.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/radius68.h"
#include "ingest/session_placement.h"
#include "ingest/session_refused.h"

namespace cairn {
namespace {

constexpr double kSigmas = 3.4 / kRadius68PerSigma2d;

// 24 photos that agree.
MapComparison SureComparison(double spread_m, double map_spread_m) {
  MapComparison comparison;
  comparison.num_expected = comparison.num_localized = comparison.fit.num_agreeing = 24;
  comparison.fit.median_residual_m = 0.05;
  comparison.spread_m = spread_m;
  comparison.map_spread_m = map_spread_m;
  return comparison;
}

TEST(LimitsOf, SizeAndTurnFollowTheSpreadsOfBothSides) {
  const MotionLimits limits =
      LimitsOf(SureComparison(57.0, 30.0), AgreementOptions(), {.session_m = 3.0, .map_m = 3.0});
  EXPECT_NEAR(limits.scale_change, kSigmas * std::hypot(3.0 / 57.0, 3.0 / 30.0), 1e-12);
  EXPECT_EQ(limits.turned_rad, limits.scale_change);
  EXPECT_NEAR(limits.moved_m, kSigmas * std::hypot(3.0, 3.0), 1e-12);
}

// Eight positions over ten meters, accurate to 3 m, may be a fifth too far apart.
TEST(LimitsOf, AMapOfAShortWalkLeavesTheSizeOpenToALongOne) {
  const PositionAccuracies accuracy = {.session_m = 3.0, .map_m = 3.0};
  EXPECT_GT(LimitsOf(SureComparison(57.0, 10.0), AgreementOptions(), accuracy).scale_change, 0.2);
  EXPECT_LT(LimitsOf(SureComparison(57.0, 57.0), AgreementOptions(), accuracy).scale_change, 0.17);
  EXPECT_EQ(LimitsOf(SureComparison(57.0, 1.0), AgreementOptions(), accuracy).scale_change, 0.5);
}

TEST(LimitsOf, AccurateSessionsKeepTheLimitsOfTheOptions) {
  const MotionLimits limits =
      LimitsOf(SureComparison(57.0, 57.0), AgreementOptions(), {.session_m = 0.1, .map_m = 0.1});
  EXPECT_EQ(limits.moved_m, AgreementOptions().max_moved_m);
  EXPECT_EQ(limits.scale_change, AgreementOptions().max_scale_change);
  EXPECT_FALSE(limits.follow_accuracy);
}

// Half of a session was put together wrongly at a seam: the map sees both halves, in two places.
TEST(RequireAgreement, RefusesASessionOfTwoPartsThatContradictEachOther) {
  MapComparison comparison = SureComparison(50.0, 50.0);
  comparison.num_expected = comparison.num_localized = 17;
  comparison.fit.num_agreeing = 9;
  comparison.anchoring.num_answers = 17;
  comparison.anchoring.session = {17, 17, 50.0};
  comparison.anchoring.winner = {9, 9, 25.0};
  comparison.anchoring.rival = {8, 8, 25.0};
  const auto require = [&] { RequireAgreement(comparison, {}, {}, "session B"); };
  EXPECT_THAT(require, ::testing::ThrowsMessage<SessionRefused>(::testing::HasSubstr(
                           "but 8 others, in 8 places, agree on another motion")));
  comparison.anchoring.rival = {4, 4, 10.0};  // As wrong answers do.
  EXPECT_NO_THROW(require());
  // A rival far smaller than the rest counts where photos were sought and most were found in it.
  comparison.anchoring.winner = {40, 40, 100.0};
  comparison.anchoring.rival = {6, 6, 10.0};
  comparison.num_sought = 1;
  comparison.num_found = comparison.num_found_by_rival = 1;
  EXPECT_NO_THROW(require());
  comparison.num_sought = 8;
  comparison.num_found = comparison.num_found_by_rival = 6;
  EXPECT_THAT(require, ::testing::ThrowsMessage<SessionRefused>(::testing::HasSubstr("6 places")));
}

}  // namespace
}  // namespace cairn
