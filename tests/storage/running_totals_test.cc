#include "storage/map/internal/running_totals.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <random>
#include <vector>

#include "core/error.h"
#include "storage/inspection/geo_box.h"
#include "support/map_builder.h"

namespace cairn {
namespace {

using testing::ErrorCodeOf;

TileRecord RecordAt(double lat_deg, double lon_deg) {
  TileRecord tile;
  tile.tile_id = TileId::Containing(Geodetic::FromDegrees(lat_deg, lon_deg, 0.0));
  tile.num_landmarks = 10;
  tile.num_descriptors = 20;
  tile.num_bytes = 300;
  return tile;
}

std::optional<GeoBox> BoundsOf(const std::map<TileId, TileRecord>& tiles) {
  std::vector<GeoBox> boxes;
  for (const auto& [id, tile] : tiles) {
    boxes.push_back(id.Bounds());
  }
  return BoxAroundAll(boxes);
}

// Random tiles come and go; what the totals say they know must be so.
void ComeAndGo(double span_lon_deg, double center_lon_deg, int min_known) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-0.5, 0.5);
  std::map<TileId, TileRecord> tiles;
  RunningTotals totals{MapTotals()};
  int num_known = 0;
  for (int step = 0; step < 400; ++step) {
    if (tiles.size() > 20 || (!tiles.empty() && random() % 3 == 0)) {
      const auto gone = std::next(tiles.begin(), random() % tiles.size());
      totals.RemoveTile(gone->second);
      tiles.erase(gone);
    } else {
      const TileRecord tile = RecordAt(
          40.0 * unit(random), std::remainder(center_lon_deg + span_lon_deg * unit(random), 360.0));
      if (tiles.emplace(tile.tile_id, tile).second) {
        totals.AddTile(tile);
      }
    }
    const std::optional<GeoBox> bounds = BoundsOf(tiles);
    if (totals.KnowsBounds()) {
      ++num_known;
      ASSERT_EQ(totals.totals().bounds.has_value(), bounds.has_value());
      if (bounds) {
        ASSERT_NEAR(totals.totals().bounds->south_rad, bounds->south_rad, 1e-12);
        ASSERT_NEAR(totals.totals().bounds->west_rad, bounds->west_rad, 1e-12);
        ASSERT_NEAR(totals.totals().bounds->north_rad, bounds->north_rad, 1e-12);
        ASSERT_NEAR(totals.totals().bounds->east_rad, bounds->east_rad, 1e-12);
      }
    }
    totals.SetBounds(bounds);
    ASSERT_EQ(totals.totals().num_tiles, std::ssize(tiles));
    ASSERT_EQ(totals.totals().payload_bytes, 300 * std::ssize(tiles));
  }
  EXPECT_GE(num_known, min_known);
}

TEST(RunningTotals, FollowACityOnTheAntimeridian) { ComeAndGo(1.0, 180.0, 250); }
TEST(RunningTotals, FollowAContinent) { ComeAndGo(170.0, 20.0, 250); }
TEST(RunningTotals, FollowTheWholeWorld) { ComeAndGo(360.0, 0.0, 1); }

TEST(RunningTotals, ATileThatIsReplacedAtTheEdgeLeavesTheBounds) {
  RunningTotals totals{MapTotals()};
  const TileRecord tile = RecordAt(49.0, 8.4);
  totals.AddTile(tile);
  totals.RemoveTile(tile);
  EXPECT_FALSE(totals.KnowsBounds());
  totals.AddTile(tile);
  EXPECT_TRUE(totals.KnowsBounds());
}

TEST(RunningTotals, CountsThatCannotBeAddedAreDamage) {
  RunningTotals totals{MapTotals()};
  TileRecord tile = RecordAt(49.0, 8.4);
  tile.num_landmarks = std::numeric_limits<int64_t>::min();
  EXPECT_EQ(ErrorCodeOf([&] { totals.RemoveTile(tile); }), ErrorCode::kMapDamaged);
}

}  // namespace
}  // namespace cairn
