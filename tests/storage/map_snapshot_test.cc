// Tests that a snapshot reads its version whatever is published, and what the store caches.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "core/error.h"
#include "storage/map/map_history.h"
#include "storage/map/map_store.h"
#include "storage/map/read_latest.h"
#include "support/map_builder.h"
#include "support/map_place.h"
#include "support/street_map.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

using testing::AddTile;
using ::testing::ElementsAre;
using testing::ErrorCodeOf;
using testing::Ids;
using testing::KeyframeAt;
using testing::NamedSession;
using testing::RandomCodebook;
using testing::RandomTile;

const Geodetic kPlace = Geodetic::FromDegrees(49.0, 8.4, 100.0);
const TileId kChanged = TileId::Containing(kPlace);
const TileId kRemoved = TileId::Containing(Geodetic::FromDegrees(49.0, 8.41, 0.0));
const TileId kAdded = TileId::Containing(Geodetic::FromDegrees(49.0015, 8.4, 0.0));

// A map of version 2, and of version 3 after Change.
class MapSnapshotTest : public testing::MapPlaceTest {
 protected:
  void SetUp() override {
    MapPlaceTest::SetUp();
    if (IsSkipped()) {
      return;
    }
    map_.emplace(MapStore::Create(Place("a")));
    MapUpdate update = store().BeginUpdate();
    update.AddCodebook(RandomCodebook());
    session_ = update.AddSession(NamedSession("old"));
    update.AddKeyframe(KeyframeAt(kPlace, session_));
    AddTile(RandomTile({.id = kChanged, .seed = 1}), &update);
    AddTile(RandomTile({.id = kRemoved, .seed = 2}), &update);
    update.Publish();
  }

  void Change() {
    MapUpdate update = store().BeginUpdate();
    update.RemoveSession(session_);
    update.AddKeyframe(KeyframeAt(kPlace, update.AddSession(NamedSession("new"))));
    AddTile(RandomTile({.id = kChanged, .seed = 3}), &update);
    AddTile(RandomTile({.id = kAdded, .seed = 4}), &update);
    update.RemoveTile(kRemoved);
    update.Publish();
  }

  MapStore& store() { return *map_; }

  std::optional<MapStore> map_;
  SessionId session_{};
};

CAIRN_ON_BOTH_KINDS_OF_MAPS(MapSnapshotTest);

TEST_P(MapSnapshotTest, ReadsItsTilesAfterTheyWereReplaced) {
  const MapSnapshot snapshot = store().Snapshot();
  const std::string digest = store().Snapshot().FindTile(kChanged)->digest;
  Change();
  const std::vector<TileId> tiles = {kChanged, kRemoved};
  EXPECT_EQ(Ids(snapshot.AllTiles(10)), tiles);
  EXPECT_EQ(Ids(snapshot.AllTiles(1)), std::vector<TileId>{kChanged});
  EXPECT_EQ(Ids(snapshot.FindTiles(BoxAround(kPlace, 1000.0))), tiles);    // By ids.
  EXPECT_EQ(Ids(snapshot.FindTiles(BoxAround(kPlace, 50'000.0))), tiles);  // By the index.
  EXPECT_EQ(snapshot.FindTile(kChanged)->digest, digest);
  EXPECT_FALSE(snapshot.FindTile(kAdded).has_value());
  EXPECT_EQ(snapshot.Info().num_tiles, 2);
  EXPECT_EQ(DecodeTile(snapshot.LoadPayload(snapshot.FindTile(kRemoved)->payload_id)).id, kRemoved);
}

TEST_P(MapSnapshotTest, ReadsItsSessionsAfterTheyWereReplaced) {
  const MapSnapshot snapshot = store().Snapshot();
  Change();
  ASSERT_EQ(snapshot.Sessions().size(), 1u);
  EXPECT_EQ(snapshot.Sessions()[0].name, "old");
  EXPECT_TRUE(snapshot.FindSession("old").has_value());
  EXPECT_FALSE(snapshot.FindSession("new").has_value());
  EXPECT_EQ(snapshot.KeyframesOfSession(session_).size(), 1u);
  ASSERT_EQ(snapshot.KeyframesOfTile(kChanged).size(), 1u);
  EXPECT_EQ(snapshot.KeyframesOfTile(kChanged)[0].session_id, session_);
  EXPECT_EQ(snapshot.Versions(10).size(), 2u);
}

TEST_P(MapSnapshotTest, OfAPrunedVersionIsUnavailable) {
  const MapSnapshot snapshot = store().Snapshot();
  const PayloadId payload_id = snapshot.FindTile(kRemoved)->payload_id;
  Change();
  Prune({.keep = 1}, &store());
  EXPECT_EQ(ErrorCodeOf([&] { snapshot.AllTiles(10); }), ErrorCode::kUnavailable);
  EXPECT_EQ(ErrorCodeOf([&] { snapshot.FindTiles(BoxAround(kPlace, 100.0)); }),
            ErrorCode::kUnavailable);
  EXPECT_EQ(ErrorCodeOf([&] { snapshot.FindTile(kRemoved); }), ErrorCode::kUnavailable);
  EXPECT_EQ(ErrorCodeOf([&] { snapshot.LoadPayload(payload_id); }), ErrorCode::kUnavailable);
  EXPECT_EQ(ErrorCodeOf([&] { snapshot.Sessions(); }), ErrorCode::kUnavailable);
  EXPECT_EQ(ErrorCodeOf([&] { snapshot.CurrentCodebook(); }), ErrorCode::kUnavailable);
  EXPECT_EQ(ErrorCodeOf([&] { snapshot.Info(); }), ErrorCode::kUnavailable);
  EXPECT_EQ(ErrorCodeOf([&] { store().Snapshot().LoadPayload(payload_id); }),
            ErrorCode::kMapDamaged);
}

TEST_P(MapSnapshotTest, ReadLatestReadsAgainWhenTheVersionIsPruned) {
  std::vector<MapVersion> versions;
  const auto read_after_prune = [&](const MapSnapshot& snapshot) {
    versions.push_back(snapshot.version());
    if (versions.size() == 1) {
      Change();
      Prune({.keep = 1}, &store());
    }
    return snapshot.AllTiles(10).size();
  };
  EXPECT_EQ(ReadLatest(store(), {}, read_after_prune), 2u);
  EXPECT_THAT(versions, ElementsAre(MapVersion(2), store().Snapshot().version()));
}

TEST_P(MapSnapshotTest, ReadLatestReadsOnceWhenNothingWasPruned) {
  int num_reads = 0;
  const auto fail = [&](const MapSnapshot&) -> int {
    ++num_reads;
    throw Error(ErrorCode::kUnavailable, "the map's server does not answer");
  };
  EXPECT_EQ(ErrorCodeOf([&] { ReadLatest(store(), {}, fail); }), ErrorCode::kUnavailable);
  EXPECT_EQ(num_reads, 1);
}

TEST_P(MapSnapshotTest, ReadsTheTilesOfABoxOnceAVersion) {
  const GeoBox box = BoxAround(kPlace, 200.0);
  store().Snapshot().FindTiles(box);
  const int64_t num_calls = store().Stats().num_calls;
  EXPECT_EQ(store().Snapshot().FindTiles(box).size(), 1u);
  EXPECT_EQ(store().Stats().num_calls - num_calls, 1);  // The version.
  Change();
  EXPECT_EQ(store().Snapshot().FindTiles(box).size(), 2u);
}

TEST_P(MapSnapshotTest, TilesHaveTheDigestsOfTheirPayloads) {
  const std::vector<TileRecord> tiles = store().Snapshot().AllTiles(10);
  Change();
  const std::vector<TileChange> changes = store().Snapshot().Diff(MapVersion(2), MapVersion(3));
  ASSERT_EQ(changes.size(), 3u);
  EXPECT_EQ(tiles[0].digest, changes[0].before->digest);
  EXPECT_EQ(store().Snapshot().FindTile(kChanged)->digest, changes[0].after->digest);
}

}  // namespace
}  // namespace cairn
