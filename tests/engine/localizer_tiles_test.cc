// Tests a localizer on tiles that are no map on disk, and on the cache of another localizer.
#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "core/error.h"
#include "engine/mapped_streets.h"
#include "support/expect_error.h"

namespace cairn {
namespace {

using testing::ErrorCodeOf;
using testing::ExpectSameAnswer;
using testing::QueryAt;
using testing::QueryPose;

// The tiles of a map, kept in memory, encoded or decoded.
class TilesInMemory : public MapTiles {
 public:
  explicit TilesInMemory(const MapSnapshot& map, bool are_decoded = false)
      : codebook_(map.CurrentCodebook()),
        records_(map.AllTiles(std::numeric_limits<int64_t>::max())) {
    const SnapshotTiles stored(map);
    for (const TileRecord& record : records_) {
      StoredTile& tile = tiles_[record.tile_id];
      tile = stored.LoadTile(record);
      if (are_decoded) {
        tile.decoded = std::make_shared<const DecodedTile>(DecodePayload(tile.payload));
        tile.payload.clear();
      }
    }
  }

  std::shared_ptr<const Codebook> CurrentCodebook() const override { return codebook_; }
  std::vector<TileRecord> FindTiles(const GeoBox& /*box*/) const override { return records_; }
  StoredTile LoadTile(const TileRecord& record) const override { return tiles_.at(record.tile_id); }

 private:
  std::shared_ptr<const Codebook> codebook_;
  std::vector<TileRecord> records_;
  std::map<TileId, StoredTile> tiles_;
};

std::shared_ptr<TileCache> NewCache() { return std::make_shared<TileCache>(size_t{1} << 28); }

class LocalizerInTiles : public testing::OneStreetTest {};

TEST_F(LocalizerInTiles, AnswersAsInTheMapOfTheTiles) {
  const LocalizeQuery query = QueryAt(*world_, QueryPose(20.0));
  const LocalizeResult expected = localizer().Localize(query);
  for (const bool are_decoded : {false, true}) {
    const TilesInMemory tiles(map_->store().Snapshot(), are_decoded);
    const LocalizeResult result = Localizer(tiles, {}, NewCache()).Localize(query);
    ExpectSameAnswer(result, expected);
    EXPECT_EQ(result.position_accuracy_m, expected.position_accuracy_m);
  }
}

TEST_F(LocalizerInTiles, AnswersWithoutAPriorAsInTheMapOfTheTiles) {
  LocalizeQuery query = QueryAt(*world_, QueryPose(20.0));
  query.prior.reset();
  const LocalizeResult expected = localizer().Localize(query);
  ASSERT_TRUE(expected.localized);
  for (const bool are_decoded : {false, true}) {
    const TilesInMemory tiles(map_->store().Snapshot(), are_decoded);
    const Localizer in_memory(tiles, {}, NewCache());
    ExpectSameAnswer(in_memory.Localize(query), expected);
    EXPECT_EQ(in_memory.Localize(query).counters.num_tiles_found,
              expected.counters.num_tiles_found);
  }
}

TEST_F(LocalizerInTiles, ASharedCacheIsOfOneIndex) {
  const std::shared_ptr<const MapStore> store(std::shared_ptr<const MapStore>(), &map_->store());
  const LocalizeQuery query = QueryAt(*world_, QueryPose(20.0));
  localizer().Localize(query);
  LocalizerOptions options;
  options.answer.min_score = 1e9;
  const Localizer sharing(store, options, localizer().cache());
  EXPECT_EQ(sharing.Localize(query).counters.num_tiles_loaded, 0);
  options.matching.index.kind = IndexKind::kExhaustive;
  EXPECT_EQ(ErrorCodeOf([&] { Localizer(store, options, localizer().cache()); }),
            ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace cairn
