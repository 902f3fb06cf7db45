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

// The tiles of a map, kept in memory.
class TilesInMemory : public MapTiles {
 public:
  explicit TilesInMemory(const MapSnapshot& map)
      : codebook_(map.CurrentCodebook()),
        records_(map.AllTiles(std::numeric_limits<int64_t>::max())) {
    const SnapshotTiles stored(map);
    for (const TileRecord& record : records_) {
      tiles_[record.tile_id] = stored.LoadTile(record);
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

class LocalizerInTiles : public testing::OneStreetTest {};

TEST_F(LocalizerInTiles, AnswersAsInTheMapOfTheTiles) {
  const TilesInMemory tiles(map_->store().Snapshot());
  const Localizer in_memory(tiles, {});
  const LocalizeQuery query = QueryAt(*world_, QueryPose(20.0));
  ExpectSameAnswer(in_memory.Localize(query), localizer().Localize(query));
}

TEST_F(LocalizerInTiles, NeedsAPrior) {
  const TilesInMemory tiles(map_->store().Snapshot());
  const Localizer in_memory(tiles, {});
  LocalizeQuery query = QueryAt(*world_, QueryPose(20.0));
  query.prior.reset();
  EXPECT_EQ(ErrorCodeOf([&] { in_memory.Localize(query); }), ErrorCode::kBadInput);
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
