#include "engine/explain_miss.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

#include "engine/mapped_streets.h"
#include "engine/nearest_tile.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;

class ExplainMissTest : public testing::OneStreetTest {
 protected:
  static MapSnapshot Snapshot() { return map_->store().Snapshot(); }
  static Geodetic Middle() {
    const GeoBox bounds = Snapshot().Info().bounds.value();
    return {0.5 * (bounds.south_rad + bounds.north_rad), 0.5 * (bounds.west_rad + bounds.east_rad),
            0.0};
  }
  static std::string NoCoverageAt(const Geodetic& position,
                                  PriorSource source = PriorSource::kClient) {
    LocalizeQuery query;
    query.prior.emplace();
    query.prior->position = position;
    query.prior->source = source;
    LocalizeResult result;
    result.reason = NotLocalizedReason::kNoCoverage;
    const MapSnapshot snapshot = Snapshot();
    return ExplainMiss(query, result, LocalizerOptions(), &snapshot);
  }
  // The distance to the nearest of all tiles.
  static double ShortestM(const Geodetic& position) {
    double shortest_m = std::numeric_limits<double>::max();
    for (const TileRecord& tile : Snapshot().AllTiles(1000)) {
      const GeoBox box = tile.tile_id.Bounds();
      const Geodetic nearest{std::clamp(position.lat_rad, box.south_rad, box.north_rad),
                             std::clamp(position.lon_rad, box.west_rad, box.east_rad), 0.0};
      shortest_m = std::min(shortest_m, GroundDistanceM(position, nearest));
    }
    return shortest_m;
  }
};

TEST_F(ExplainMissTest, SlipsOfCoordinatesAreNamed) {
  const Geodetic at = Middle();
  EXPECT_THAT(NoCoverageAt({at.lon_rad, at.lat_rad, 0.0}),
              ::testing::MatchesRegex("the nearest tile is [0-9],[0-9]+ km away; are latitude and "
                                      "longitude swapped\\?"));
  EXPECT_THAT(NoCoverageAt({at.lat_rad, -at.lon_rad, 0.0}), HasSubstr("West is negative"));
  EXPECT_THAT(NoCoverageAt({-at.lat_rad, at.lon_rad, 0.0}), HasSubstr("South is negative"));
  EXPECT_THAT(NoCoverageAt({}), HasSubstr("a receiver without a fix"));
}

TEST_F(ExplainMissTest, OtherPositionsGetTheDistanceAndAHint) {
  Geodetic near = Middle();
  near.lat_rad += 1e-3;  // 6.4 km.
  EXPECT_THAT(NoCoverageAt(near), HasSubstr("km away; leave the position out"));
  EXPECT_THAT(NoCoverageAt(near, PriorSource::kPhoto), HasSubstr("the photo's EXIF"));
  Geodetic beside = Middle();
  beside.lat_rad += 5e-5;  // 320 m.
  EXPECT_THAT(NoCoverageAt(beside), HasSubstr(" m away; a larger accuracy"));
}

TEST_F(ExplainMissTest, TheNearestTileIsFound) {
  EXPECT_LT(NearestTileM(Snapshot(), Middle()).value(), 1e3);
  for (const auto& [north_rad, east_rad] :
       {std::pair{1e-4, 0.0}, {0.0, -1e-3}, {1e-2, 0.0}, {0.0, 0.3}, {-0.2, 0.0}}) {
    const Geodetic middle = Middle();
    const Geodetic position{middle.lat_rad + north_rad, middle.lon_rad + east_rad, 0.0};
    EXPECT_NEAR(NearestTileM(Snapshot(), position).value(), ShortestM(position),
                0.01 * ShortestM(position));
  }
}

TEST_F(ExplainMissTest, AMapWithoutTilesSaysSo) {
  const testing::TempDir dir;
  const MapStore store = MapStore::Create(dir.File("empty.gpkg"));
  const MapSnapshot snapshot = store.Snapshot();
  EXPECT_FALSE(NearestTileM(snapshot, Middle()).has_value());
  LocalizeResult result;
  result.reason = NotLocalizedReason::kNoCoverage;
  EXPECT_THAT(ExplainMiss({}, result, LocalizerOptions(), &snapshot), HasSubstr("no tiles yet"));
}

TEST_F(ExplainMissTest, EveryReasonHasASentence) {
  using Reason = NotLocalizedReason;
  for (const Reason reason :
       {Reason::kNoCoverage, Reason::kTooFewFeatures, Reason::kTooFewMatches,
        Reason::kTooFewInliers, Reason::kAmbiguous, Reason::kPriorMismatch, Reason::kTimeout}) {
    LocalizeResult result;
    result.reason = reason;
    LocalizeQuery query;
    query.prior.emplace();
    const std::string text = ExplainMiss(query, result, LocalizerOptions(), nullptr);
    EXPECT_GT(text.size(), 20u) << NotLocalizedReasonName(reason);
    EXPECT_TRUE(text.find(';') != std::string::npos || text.find('?') != std::string::npos) << text;
  }
}

TEST_F(ExplainMissTest, AnswersWithoutAPoseHaveTheSentence) {
  LocalizeQuery query;
  query.features.descriptors.resize(0, 128);
  const LocalizeResult featureless = map_->localizer().Localize(query);
  EXPECT_EQ(featureless.reason, NotLocalizedReason::kTooFewFeatures);
  EXPECT_THAT(featureless.reason_text, HasSubstr("shows 0 features, and a pose needs 6"));
}

}  // namespace
}  // namespace cairn
