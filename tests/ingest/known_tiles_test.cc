#include "ingest/place/known_tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "engine/mapped_streets.h"
#include "storage/tile/tile_codec.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

using testing::MappedStreets;
using testing::StreetWorld;

int64_t CountKeyframesOf(SessionId session_id, const Tile& tile) {
  return std::count_if(
      tile.keyframes.begin(), tile.keyframes.end(),
      [&](const TileKeyframe& keyframe) { return keyframe.session_id == session_id; });
}

// Two sessions of one street, of which the second is replaced.
class KnownTilesTest : public ::testing::Test {
 protected:
  const StreetWorld world_;
  const MappedStreets map_{{world_, world_}};
  const MapSnapshot snapshot_ = map_.store().Snapshot();
  const std::vector<TileRecord> stored_ = snapshot_.AllTiles(std::numeric_limits<int64_t>::max());
  const SessionId first_ = snapshot_.FindSession("street 0")->id;
  const SessionId second_ = snapshot_.FindSession("street 1")->id;
};

std::optional<TileRecord> RecordOf(TileId tile_id, const MapTiles& map) {
  for (const TileRecord& record : map.FindTiles(tile_id.Bounds())) {
    if (record.tile_id == tile_id) {
      return record;
    }
  }
  return std::nullopt;
}

TEST_F(KnownTilesTest, LackTheReplacedSession) {
  const KnownTiles known(snapshot_, second_);
  ASSERT_FALSE(stored_.empty());
  for (const TileRecord& stored : stored_) {
    const std::optional<TileRecord> record = RecordOf(stored.tile_id, known);
    ASSERT_TRUE(record);
    EXPECT_EQ(2 * record->num_keyframes, stored.num_keyframes);
    const auto decoded = known.LoadTile(*record).decoded;
    const Tile& searched = decoded->tile;
    EXPECT_EQ(CountKeyframesOf(second_, searched), 0);
    EXPECT_EQ(CountKeyframesOf(first_, searched), record->num_keyframes);
    EXPECT_EQ(searched.num_landmarks(), known.Find(stored.tile_id)->num_landmarks());
  }
}

TEST_F(KnownTilesTest, WithoutAReplacedSessionAreThoseOfTheMap) {
  const KnownTiles known(snapshot_);
  for (const TileRecord& stored : stored_) {
    EXPECT_EQ(RecordOf(stored.tile_id, known)->digest, stored.digest);
    EXPECT_TRUE(testing::SameTile(known.LoadTile(stored).decoded->tile,
                                  DecodeTile(snapshot_.LoadPayload(stored.payload_id))));
    EXPECT_EQ(known.Find(stored.tile_id)->num_landmarks(),
              static_cast<size_t>(stored.num_landmarks));
  }
}

TEST_F(KnownTilesTest, AreDecodedOnce) {
  const KnownTiles known(snapshot_, second_);
  const TileId tile_id = stored_.front().tile_id;
  EXPECT_EQ(known.Find(tile_id), known.Find(tile_id));
  const TileId elsewhere = tile_id.WithIndices(tile_id.easting_idx() + 50, tile_id.northing_idx());
  EXPECT_EQ(known.Find(elsewhere), nullptr);
}

}  // namespace
}  // namespace cairn
