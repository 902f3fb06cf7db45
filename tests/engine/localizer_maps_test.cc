// Tests the localizer on maps of several streets: ambiguity, borders, updates.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/angles.h"
#include "core/error.h"
#include "engine/mapped_streets.h"

namespace cairn {
namespace {

using ::testing::AnyOf;
using testing::ExpectPose;
using testing::MappedStreets;
using testing::QueryAt;
using testing::QueryPose;
using testing::StreetWorld;
using testing::StreetWorldOptions;

TEST(Localizer, SaysNoCoverageOnAnEmptyMap) {
  const StreetWorld world;
  const MappedStreets map({});
  LocalizeQuery query = QueryAt(world, QueryPose(20.0));
  EXPECT_EQ(map.localizer().Localize(query).reason, NotLocalizedReason::kNoCoverage);
  query.prior.reset();
  EXPECT_EQ(map.localizer().Localize(query).reason, NotLocalizedReason::kNoCoverage);
}

TEST(Localizer, AWarmQueryReadsTheMapOnce) {
  const StreetWorld world;
  const MappedStreets map({world});
  const LocalizeQuery query = QueryAt(world, QueryPose(20.0));
  map.localizer().Localize(query);
  const int64_t num_calls_before = map.store().Stats().num_calls;
  EXPECT_TRUE(map.localizer().Localize(query).localized);
  EXPECT_EQ(map.store().Stats().num_calls - num_calls_before, 1);
}

TEST(Localizer, SaysAmbiguousBetweenTwoEqualStreets) {
  StreetWorldOptions options;
  options.length_m = 20.0;
  options.num_landmarks = 600;
  const StreetWorld here(options);
  options.origin = GeodeticFromEcef(EcefFromEnu(options.origin) * Eigen::Vector3d(0.0, 30.0, 0.0));
  const StreetWorld same_again(options);
  const MappedStreets map({here, same_again});
  LocalizeQuery query = QueryAt(here, QueryPose(8.0));
  query.prior->accuracy_m = 40.0;
  const LocalizeResult result = map.localizer().Localize(query);
  EXPECT_FALSE(result.localized);
  EXPECT_EQ(result.reason, NotLocalizedReason::kAmbiguous);
}

// What became of queries along a street whose facades repeat.
struct RepeatedStreetTally {
  int num_right = 0, num_ambiguous = 0, num_wrong = 0, num_other = 0;
};

RepeatedStreetTally QueryRepeatedStreet(const StreetWorldOptions& options) {
  const StreetWorld world(options);
  const MappedStreets map({world});
  RepeatedStreetTally tally;
  for (double x_m = 2.0; x_m < options.length_m; x_m += 3.5) {
    const Rigid3d cam_from_enu = QueryPose(x_m);
    LocalizeQuery query = QueryAt(world, cam_from_enu);
    query.prior->accuracy_m = 40.0;
    const LocalizeResult result = map.localizer().Localize(query);
    if (!result.localized) {
      ++(result.reason == NotLocalizedReason::kAmbiguous ? tally.num_ambiguous : tally.num_other);
      continue;
    }
    const Rigid3d cam_from_ecef = cam_from_enu * EcefFromEnu(options.origin).Inverse();
    const double error_m =
        (result.cam_from_ecef.Inverse().translation - cam_from_ecef.Inverse().translation).norm();
    ++(error_m < 0.5 ? tally.num_right : tally.num_wrong);
  }
  return tally;
}

TEST(Localizer, SaysAmbiguousWhereFacadesRepeat) {
  StreetWorldOptions options;
  options.length_m = 100.0;
  options.num_landmarks = 3000;
  for (const double period_m : {20.0, 40.0}) {
    options.repeat_period_m = period_m;
    const RepeatedStreetTally tally = QueryRepeatedStreet(options);
    EXPECT_EQ(tally.num_wrong, 0) << period_m;
    EXPECT_GE(tally.num_ambiguous, 15) << period_m;
  }
}

TEST(Localizer, TellsRepeatedFacadesApartByWhatIsUnique) {
  StreetWorldOptions options;
  options.length_m = 100.0;
  options.num_landmarks = 3000;
  options.repeat_period_m = 25.0;
  options.unique_ratio = 0.5;
  const RepeatedStreetTally tally = QueryRepeatedStreet(options);
  EXPECT_EQ(tally.num_wrong, 0);
  EXPECT_GE(tally.num_right, 22);  // Of 28; none if effective inliers alone had to tell.
}

// A street whose first camera stands `west_m` west and `south_m` south of the north-east corner of
// a tile.
StreetWorldOptions StreetNearCorner(double west_m, double south_m) {
  StreetWorldOptions options;
  options.num_landmarks = 2000;
  const Geodetic corner = TileId::Containing(options.origin).Corners()[2];
  options.origin = GeodeticFromEcef(EcefFromEnu({corner.lat_rad, corner.lon_rad, 408.0}) *
                                    Eigen::Vector3d(-west_m, -south_m, 0.0));
  return options;
}

// Asks along the street with priors of 5, 20 and 50 m that are off by about as much as they say.
void ExpectAnswersForEveryPrior(const StreetWorld& world, size_t min_tiles) {
  const MappedStreets map({world});
  size_t most_tiles = 0;
  int i = 0;
  for (const double accuracy_m : {5.0, 20.0, 50.0}) {
    for (const double x_m : {10.0, 19.0, 21.0, 34.0, 50.0}) {
      const Rigid3d cam_from_enu = QueryPose(x_m);
      LocalizeQuery query = QueryAt(world, cam_from_enu);
      const double angle_rad = 2.4 * i++;
      const Eigen::Vector3d offset =
          accuracy_m * Eigen::Vector3d(std::cos(angle_rad), std::sin(angle_rad), 0.0);
      query.prior->position = GeodeticFromEcef(EcefFromEnu(world.options().origin) *
                                               (cam_from_enu.Inverse().translation + offset));
      query.prior->accuracy_m = accuracy_m;
      const LocalizeResult result = map.localizer().Localize(query);
      SCOPED_TRACE(accuracy_m);
      SCOPED_TRACE(x_m);
      ExpectPose(result, world, cam_from_enu, 0.05, 0.1 * kRadPerDeg);
      most_tiles = std::max(most_tiles, result.tiles.size());
    }
  }
  EXPECT_GE(most_tiles, min_tiles);
}

TEST(Localizer, AnswersAcrossATileBorderForEveryPrior) {
  ExpectAnswersForEveryPrior(StreetWorld(StreetNearCorner(20.0, 75.0)), 2);
}

TEST(Localizer, AnswersAcrossATileCornerForEveryPrior) {
  ExpectAnswersForEveryPrior(StreetWorld(StreetNearCorner(20.0, 0.0)), 4);
}

TEST(Localizer, AnswersAcrossAZoneBorderForEveryPrior) {
  StreetWorldOptions options;
  options.origin = Geodetic::FromDegrees(47.0, 11.99974, 600.0);  // 20 m west of zone 33.
  options.num_landmarks = 2000;
  ExpectAnswersForEveryPrior(StreetWorld(options), 2);
}

TEST(Localizer, AnswersBesideATileThatIsMissing) {
  // One street through three tiles, of which the middle one was never mapped.
  StreetWorldOptions west = StreetNearCorner(60.0, 75.0), east = west;
  west.length_m = 55.0;
  west.num_landmarks = 1500;
  east.start_m = 60.0 + TileId::kSideM + 5.0;
  east.length_m = 55.0;
  east.num_landmarks = 1500;
  east.seed = 77;
  const StreetWorld west_world(west), east_world(east);
  const MappedStreets map({west_world, east_world});
  const auto ask = [&map](const StreetWorld& world, double x_m) {
    LocalizeQuery query = QueryAt(world, QueryPose(x_m));
    query.prior->accuracy_m = 50.0;
    return map.localizer().Localize(query);
  };
  for (const double x_m : {20.0, 50.0}) {
    ExpectPose(ask(west_world, x_m), west_world, QueryPose(x_m), 0.05, 0.1 * kRadPerDeg);
  }
  const double in_east_m = east.start_m + 20.0;
  ExpectPose(ask(east_world, in_east_m), east_world, QueryPose(in_east_m), 0.05, 0.1 * kRadPerDeg);
  // In the gap between the two, with both in reach: a miss with its reason.
  StreetWorldOptions unmapped = west;
  unmapped.seed = 5;
  unmapped.start_m = 100.0;
  const StreetWorld gap_world(unmapped);
  LocalizeQuery lost = QueryAt(gap_world, QueryPose(130.0));
  lost.prior->accuracy_m = 80.0;
  const LocalizeResult result = map.localizer().Localize(lost);
  EXPECT_FALSE(result.localized);
  EXPECT_EQ(result.counters.num_tiles_searched, 2);
  EXPECT_THAT(result.reason,
              AnyOf(NotLocalizedReason::kTooFewMatches, NotLocalizedReason::kTooFewInliers));
}

TEST(Localizer, WorksAcrossAZoneBorder) {
  StreetWorldOptions options;
  options.origin = Geodetic::FromDegrees(47.0, 11.9996, 600.0);  // 30 m west of zone 33.
  const StreetWorld world(options);
  const MappedStreets map({world});
  const Rigid3d cam_from_enu = QueryPose(29.0);
  const LocalizeResult result = map.localizer().Localize(QueryAt(world, cam_from_enu));
  ExpectPose(result, world, cam_from_enu, 0.05, 0.1 * kRadPerDeg);
  ASSERT_GE(result.tiles.size(), 2u);
  EXPECT_NE(result.tiles.front().zone(), result.tiles.back().zone());
}

TEST(Localizer, SeesAnUpdateOfTheMapUnlessAskedForAVersion) {
  StreetWorldOptions options;
  options.length_m = 30.0;
  options.num_landmarks = 600;
  const StreetWorld first(options);
  options.seed = 7;
  options.origin = GeodeticFromEcef(EcefFromEnu(options.origin) * Eigen::Vector3d(0.0, 500.0, 0.0));
  const StreetWorld second(options);
  MappedStreets map({first});
  const LocalizeQuery query = QueryAt(second, QueryPose(12.0));
  EXPECT_EQ(map.localizer().Localize(query).reason, NotLocalizedReason::kNoCoverage);
  const MapSnapshot before = map.store().Snapshot();
  map.Add(second);
  EXPECT_TRUE(map.localizer().Localize(query).localized);
  const LocalizeResult result = map.localizer().LocalizeIn(before, query);
  EXPECT_EQ(result.reason, NotLocalizedReason::kNoCoverage);
  EXPECT_EQ(result.map_version, before.version());
}

TEST(Localizer, RefusesOptionsThatMakeNoSense) {
  LocalizerOptions options;
  options.answer.ambiguous_score_ratio = 2.0;
  EXPECT_THROW(MappedStreets({}, options), Error);
}

}  // namespace
}  // namespace cairn
