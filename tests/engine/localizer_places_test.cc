// Tests the localizer on queries without a prior in maps of many places.
#include <gtest/gtest.h>

#include <vector>

#include "core/angles.h"
#include "engine/mapped_streets.h"

namespace cairn {
namespace {

using testing::ExpectPose;
using testing::MappedStreets;
using testing::QueryAt;
using testing::QueryPose;
using testing::StreetWorld;
using testing::StreetWorldOptions;

// Short streets, 600 m apart, each in tiles of its own.
StreetWorldOptions StreetNumber(int i) {
  StreetWorldOptions options;
  options.length_m = 20.0;
  options.num_landmarks = 400;
  options.origin = GeodeticFromEcef(EcefFromEnu(options.origin) *
                                    Eigen::Vector3d(600.0 * (i % 5), 600.0 * (i / 5), 0.0));
  options.seed = static_cast<uint64_t>(100 + i);
  return options;
}

LocalizeQuery QueryWithoutPrior(const StreetWorld& world) {
  LocalizeQuery query = QueryAt(world, QueryPose(8.0));
  query.prior.reset();
  return query;
}

class ManyStreetsTest : public ::testing::Test {
 protected:
  static constexpr int kNumStreets = 24;

  static void SetUpTestSuite() {
    std::vector<StreetWorld> worlds;
    for (int i = 0; i < kNumStreets; ++i) {
      worlds.emplace_back(StreetNumber(i));
    }
    map_ = new MappedStreets(worlds);
  }
  static void TearDownTestSuite() { delete map_; }

  inline static MappedStreets* map_ = nullptr;
};

TEST_F(ManyStreetsTest, AQueryWithoutAPriorIsAnsweredInEachPlace) {
  const int64_t num_tiles = map_->store().Snapshot().Info().num_tiles;
  ASSERT_GT(num_tiles, LocalizerOptions().tiles.max_tiles);
  for (const int i : {0, 6, 17, kNumStreets - 1}) {
    const StreetWorld world(StreetNumber(i));
    const LocalizeResult result = map_->localizer().Localize(QueryWithoutPrior(world));
    SCOPED_TRACE(i);
    ExpectPose(result, world, QueryPose(8.0), 0.05, 0.1 * kRadPerDeg);
    EXPECT_EQ(result.counters.num_tiles_found, num_tiles);
    EXPECT_LT(result.counters.num_tiles_searched, num_tiles);
    EXPECT_GE(result.counters.num_places_searched, 1);
    EXPECT_TRUE(result.counters.tile_limit_hit);
  }
}

TEST_F(ManyStreetsTest, WithoutGravityToo) {
  const StreetWorld world(StreetNumber(20));
  LocalizeQuery query = QueryWithoutPrior(world);
  query.down_in_cam.reset();
  ExpectPose(map_->localizer().Localize(query), world, QueryPose(8.0), 0.05, 0.1 * kRadPerDeg);
}

TEST_F(ManyStreetsTest, AQueryOfElsewhereSaysHowMuchWasSearched) {
  const LocalizeResult result =
      map_->localizer().Localize(QueryWithoutPrior(StreetWorld(StreetNumber(99))));
  EXPECT_FALSE(result.localized);
  EXPECT_NE(result.reason, NotLocalizedReason::kNoCoverage);
  EXPECT_GE(result.counters.num_places_searched, 1);
  EXPECT_GT(result.counters.num_tiles_found, result.counters.num_tiles_searched);
}

TEST_F(ManyStreetsTest, TheAnswerDoesNotDependOnTheThreads) {
  LocalizerOptions options;
  options.num_threads = 4;
  const LocalizeQuery query = QueryWithoutPrior(StreetWorld(StreetNumber(11)));
  testing::ExpectSameAnswer(map_->WithOptions(options).Localize(query),
                            map_->localizer().Localize(query));
}

TEST(LocalizerPlaces, TwoEqualStreetsAreAmbiguous) {
  StreetWorldOptions here = StreetNumber(0), there = StreetNumber(4);
  there.seed = here.seed;
  const StreetWorld world(here);
  const MappedStreets map({world, StreetWorld(there)});
  const LocalizeResult result = map.localizer().Localize(QueryWithoutPrior(world));
  EXPECT_FALSE(result.localized);
  EXPECT_EQ(result.reason, NotLocalizedReason::kAmbiguous);
  EXPECT_TRUE(result.matches.empty());
}

TEST(LocalizerPlaces, SeesAnUpdateOfTheMap) {
  const StreetWorld second(StreetNumber(3));
  MappedStreets map({StreetWorld(StreetNumber(1))});
  EXPECT_FALSE(map.localizer().Localize(QueryWithoutPrior(second)).localized);
  map.Add(second);
  ExpectPose(map.localizer().Localize(QueryWithoutPrior(second)), second, QueryPose(8.0), 0.05,
             0.1 * kRadPerDeg);
}

}  // namespace
}  // namespace cairn
