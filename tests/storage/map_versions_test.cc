// Versions: what they record, going back to one, and forgetting some.
#include "storage/map/map_versions.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/error.h"
#include "storage/map/map_history.h"
#include "storage/map/map_store.h"
#include "support/map_builder.h"
#include "support/map_place.h"
#include "support/places.h"
#include "support/raw_sql.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

using testing::ContentOf;
using ::testing::ElementsAre;
using testing::ErrorCodeOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::PutPlace;
using testing::RemovePlace;
using testing::RowsOf;
using testing::TileOfPlace;

class MapVersions : public testing::MapPlaceTest {
 protected:
  void SetUp() override {
    MapPlaceTest::SetUp();
    if (!IsSkipped()) {
      path_ = Place("a");
      map_.emplace(MapStore::Create(path_));
    }
  }

  MapVersion Put(int place, uint64_t seed) {
    MapUpdate update = store().BeginUpdate();
    PutPlace(place, seed, &update);
    return update.Publish({VersionKind::kIngest, testing::NameOfPlace(place), "one place"});
  }

  MapVersion Remove(int place) {
    MapUpdate update = store().BeginUpdate();
    RemovePlace(place, &update);
    return update.Publish({VersionKind::kRemove, testing::NameOfPlace(place), ""});
  }

  std::vector<TileChange> Diff(int64_t from, int64_t to) {
    return store().Snapshot().Diff(MapVersion(from), MapVersion(to));
  }

  int64_t Count(const std::string& table) {
    return std::stoll(RowsOf(path_, "SELECT count(*) FROM " + table).at(0));
  }

  MapStore& store() { return *map_; }

  std::string path_;
  std::optional<MapStore> map_;
};

CAIRN_ON_BOTH_KINDS_OF_MAPS(MapVersions);

TEST_P(MapVersions, SayWhatEachUpdateWas) {
  Put(0, 1);
  Put(1, 2);
  const std::vector<VersionRecord> versions = store().Snapshot().Versions(10);
  ASSERT_EQ(versions.size(), 3u);
  EXPECT_EQ(versions[0].version, MapVersion(3));
  EXPECT_EQ(versions[0].kind, "ingest");
  EXPECT_EQ(versions[0].session, "place 1");
  EXPECT_EQ(versions[0].summary, "one place");
  EXPECT_NE(versions[0].author, "");
  EXPECT_EQ(versions[0].totals.num_tiles, 2);
  EXPECT_EQ(versions[0].totals.num_keyframes, 4);
  EXPECT_EQ(versions[1].totals.num_landmarks, 20);
  EXPECT_EQ(versions[2].kind, "create");
  EXPECT_EQ(versions[2].totals.num_tiles, 0);
  EXPECT_FALSE(versions[2].totals.bounds.has_value());
  EXPECT_EQ(store().Snapshot().Versions(1).size(), 1u);
}

TEST_P(MapVersions, DiffNamesTheTilesThatDiffer) {
  Put(0, 1);
  Put(1, 2);
  Put(0, 3);
  Remove(1);
  const std::vector<TileChange> changes = Diff(2, 5);
  ASSERT_EQ(changes.size(), 1u);
  EXPECT_EQ(changes[0].tile_id, TileOfPlace(0));
  ASSERT_TRUE(changes[0].before && changes[0].after);
  EXPECT_NE(changes[0].before->digest, changes[0].after->digest);
  EXPECT_EQ(changes[0].before->digest.size(), 32u);
  const std::vector<TileChange> added = Diff(2, 3);
  ASSERT_EQ(added.size(), 1u);
  EXPECT_FALSE(added[0].before.has_value());
  EXPECT_EQ(added[0].after->num_landmarks, 20);
  EXPECT_GT(added[0].after->num_bytes, 0);
  const std::vector<TileChange> backwards = Diff(3, 2);
  ASSERT_EQ(backwards.size(), 1u);
  EXPECT_FALSE(backwards[0].after.has_value());
  EXPECT_THAT(Diff(4, 4), IsEmpty());
  EXPECT_EQ(Diff(1, 4).size(), 2u);
  EXPECT_THAT(Diff(1, 1), IsEmpty());
}

TEST_P(MapVersions, DiffSaysWhichVersionsThereAre) {
  Put(0, 1);
  try {
    Diff(1, 7);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kNotFound);
    EXPECT_THAT(error.what(), HasSubstr("has no version 7; it has versions 1 to 2"));
  }
}

TEST_P(MapVersions, RollBackBringsBackTheContentToTheByte) {
  Put(0, 1);
  Put(1, 2);
  const std::vector<std::string> content = ContentOf(path_);
  Put(0, 3);
  Remove(1);
  Put(2, 4);
  const std::vector<std::string> later = ContentOf(path_);
  EXPECT_EQ(RollBack(MapVersion(3), &store()), MapVersion(7));
  EXPECT_EQ(ContentOf(path_), content);
  EXPECT_THAT(Diff(3, 7), IsEmpty());
  EXPECT_THAT(store().Check({}).problems, IsEmpty());
  const VersionRecord version = store().Snapshot().Versions(1).at(0);
  EXPECT_EQ(version.kind, "rollback");
  EXPECT_THAT(version.summary, HasSubstr("version 3"));
  EXPECT_EQ(version.totals.num_tiles, 2);

  EXPECT_EQ(RollBack(MapVersion(6), &store()), MapVersion(8));
  EXPECT_EQ(ContentOf(path_), later);
  EXPECT_THAT(store().Check({}).problems, IsEmpty());
  EXPECT_EQ(RollBack(MapVersion(1), &store()), MapVersion(9));
  EXPECT_EQ(store().Snapshot().Info().num_sessions, 0);
  EXPECT_EQ(store().Snapshot().CurrentCodebook(), nullptr);
  EXPECT_THAT(store().Check({}).problems, IsEmpty());
}

TEST_P(MapVersions, RollBackToTheLatestIsRefused) {
  Put(0, 1);
  EXPECT_EQ(ErrorCodeOf([&] { RollBack(MapVersion(2), &store()); }), ErrorCode::kConflict);
  EXPECT_EQ(store().Snapshot().version(), MapVersion(2));
}

TEST_P(MapVersions, IdsGoOnAfterARollback) {
  Put(0, 1);
  Put(0, 2);
  RollBack(MapVersion(2), &store());
  MapUpdate update = store().BeginUpdate();
  EXPECT_EQ(update.ReserveLandmarkIds(1), LandmarkId(41));
  EXPECT_EQ(update.AddSession(testing::NamedSession("next")), SessionId(3));
}

TEST_P(MapVersions, EqualTilesAreStoredOnce) {
  Put(0, 1);
  const TileRecord tile = *store().Snapshot().FindTile(TileOfPlace(0));
  const LargeVector<uint8_t> payload = store().Snapshot().LoadPayload(tile.payload_id);
  MapUpdate same = store().BeginUpdate();
  EXPECT_EQ(same.PutTile(tile, payload), tile.payload_id);
  same.Publish();
  EXPECT_THAT(Diff(2, 3), IsEmpty());
  MapUpdate around = store().BeginUpdate();
  around.RemoveTile(tile.tile_id);
  EXPECT_EQ(around.PutTile(tile, payload), tile.payload_id);
  around.Publish();
  EXPECT_THAT(Diff(2, 4), IsEmpty());
  EXPECT_EQ(Count("cairn_payloads"), 1);
  EXPECT_EQ(Count("cairn_past_tiles"), 0);
  MapUpdate gone = store().BeginUpdate();
  gone.RemoveTile(tile.tile_id);
  gone.Publish();
  MapUpdate back = store().BeginUpdate();
  EXPECT_EQ(back.PutTile(tile, payload), tile.payload_id);
  back.Publish();
  EXPECT_EQ(Diff(4, 5).size(), 1u);
  EXPECT_THAT(Diff(4, 6), IsEmpty());
  EXPECT_EQ(Count("cairn_payloads"), 1);
  EXPECT_THAT(store().Check({}).problems, IsEmpty());
}

TEST_P(MapVersions, APayloadThatIsNotWhatItsDigestSaysIsNotTakenForAnother) {
  Put(0, 1);
  const TileRecord tile = *store().Snapshot().FindTile(TileOfPlace(0));
  const LargeVector<uint8_t> payload = store().Snapshot().LoadPayload(tile.payload_id);
  testing::ExecuteRaw(path_, "UPDATE cairn_payloads SET bytes = substr(bytes, 2)");
  MapUpdate update = store().BeginUpdate();
  EXPECT_EQ(ErrorCodeOf([&] { update.PutTile(tile, payload); }), ErrorCode::kMapDamaged);
}

TEST_P(MapVersions, WhatOneUpdateAddsAndRemovesLeavesNoTrace) {
  Put(0, 1);
  MapUpdate update = store().BeginUpdate();
  PutPlace(1, 2, &update);
  PutPlace(1, 3, &update);
  RemovePlace(1, &update);
  update.Publish();
  EXPECT_EQ(Count("cairn_past_tiles"), 0);
  EXPECT_EQ(Count("cairn_past_sessions"), 0);
  EXPECT_EQ(Count("cairn_past_keyframes"), 0);
  EXPECT_EQ(Count("cairn_payloads"), 1);
  EXPECT_THAT(store().Check({}).problems, IsEmpty());
}

TEST_P(MapVersions, ACodebookOfEqualBytesKeepsItsId) {
  MapUpdate update = store().BeginUpdate();
  const CodebookId first = update.AddCodebook(testing::RandomCodebook());
  EXPECT_EQ(update.AddCodebook(testing::RandomCodebook()), first);
  update.Publish();
  EXPECT_EQ(Count("cairn_codebooks"), 1);
}

TEST_P(MapVersions, PruneKeepsTheNewest) {
  for (int seed = 1; seed <= 5; ++seed) {
    Put(0, seed);
  }
  const std::vector<std::string> content = ContentOf(path_);
  const PruneReport report = Prune({.keep = 3}, &store());
  EXPECT_EQ(report.num_versions_gone, 4);
  EXPECT_GT(report.num_payload_bytes_gone, 0);
  EXPECT_EQ(report.version, MapVersion(7));
  EXPECT_EQ(ContentOf(path_), content);
  EXPECT_THAT(RowsOf(path_, "SELECT version FROM cairn_versions ORDER BY version"),
              ElementsAre("5", "6", "7"));
  EXPECT_EQ(Count("cairn_payloads"), 2);
  EXPECT_THAT(store().Check({}).problems, IsEmpty());
  EXPECT_EQ(store().Snapshot().Versions(1).at(0).kind, "prune");

  EXPECT_EQ(Prune({.keep = 3}, &store()).num_versions_gone, 0);  // Again: nothing is left to do.
  EXPECT_EQ(store().Snapshot().version(), MapVersion(7));
  try {
    RollBack(MapVersion(2), &store());
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kNotFound);
    EXPECT_THAT(error.what(), HasSubstr("it has versions 5 to 7"));
  }
  RollBack(MapVersion(5), &store());
  EXPECT_THAT(store().Check({}).problems, IsEmpty());
  Prune({.keep = 1}, &store());
  EXPECT_EQ(Count("cairn_past_tiles"), 0);
  EXPECT_EQ(Count("cairn_payloads"), 1);
  EXPECT_THAT(store().Check({}).problems, IsEmpty());
}

TEST_P(MapVersions, PruneForgetsWhatIsOlderThanATime) {
  for (int seed = 1; seed <= 3; ++seed) {
    Put(0, seed);
  }
  testing::ExecuteRaw(path_,
                      "UPDATE cairn_versions SET created_at = '2026-01-0' || version || "
                      "'T00:00:00Z'");
  EXPECT_EQ(Prune({.older_than = "2025-12-31T00:00:00Z"}, &store()).num_versions_gone, 0);
  EXPECT_EQ(Prune({.older_than = "2026-01-03T00:00:00Z"}, &store()).num_versions_gone, 2);
  EXPECT_THAT(RowsOf(path_, "SELECT version FROM cairn_versions ORDER BY version"),
              ElementsAre("3", "4", "5"));
  EXPECT_THAT(store().Check({}).problems, IsEmpty());
}

TEST_P(MapVersions, PruneRefusesWhatMakesNoSense) {
  for (const PruneOptions& options :
       {PruneOptions{}, PruneOptions{.keep = 0}, PruneOptions{.older_than = "yesterday"},
        PruneOptions{.older_than = "2026-02-30T00:00:00Z"},
        PruneOptions{.keep = 1, .older_than = "2026-01-01T00:00:00Z"}}) {
    EXPECT_EQ(ErrorCodeOf([&] { Prune(options, &store()); }), ErrorCode::kInvalidArgument);
  }
}

// The tile in the middle is damaged, so an update that read it would end with an error.
TEST_P(MapVersions, BoundsAreFoundFromTheTilesAtTheEdges) {
  const TileId middle = testing::TileAt(49.2, 8.6), far = testing::TileAt(49.9, 9.9);
  std::vector<TileId> others;
  for (const double lat_deg : {49.0, 49.4}) {
    for (const double lon_deg : {8.4, 8.8}) {
      others.push_back(testing::TileAt(lat_deg, lon_deg));
    }
  }
  const auto update = [&](bool add, std::vector<TileId> ids) {
    MapUpdate change = store().BeginUpdate();
    if (add) {
      change.AddCodebook(testing::RandomCodebook());
    }
    for (const TileId& id : ids) {
      add ? void(testing::AddTile(testing::RandomTile({.id = id}), &change))
          : change.RemoveTile(id);
    }
    change.Publish();
    const GeoBox box = *store().Snapshot().Info().bounds;
    return std::vector<double>{box.south_rad, box.west_rad, box.north_rad, box.east_rad};
  };
  const std::vector<double> alone = update(true, others);
  update(true, {middle, far});
  testing::ExecuteRaw(
      path_, fmt::format("UPDATE coverage SET tile_id = 5 WHERE tile_id = {}", middle.value()));
  EXPECT_EQ(update(false, {far}), alone);
}

TEST_P(MapVersions, CompactingKeepsEveryVersion) {
  if (GetParam() == testing::MapKind::kServer) {
    GTEST_SKIP() << "of files only";
  }
  for (int seed = 1; seed <= 4; ++seed) {
    Put(0, seed);
  }
  Prune({.keep = 2}, &store());
  const std::vector<std::string> content = ContentOf(path_);
  const std::vector<std::string> versions = RowsOf(path_, "SELECT * FROM v_versions");
  CompactMap(&store());
  EXPECT_THAT(RowsOf(path_, "SELECT freelist_count FROM pragma_freelist_count"), ElementsAre("0"));
  EXPECT_EQ(ContentOf(path_), content);
  EXPECT_EQ(RowsOf(path_, "SELECT * FROM v_versions"), versions);
  EXPECT_THAT(store().Check({}).problems, IsEmpty());
  const MapUpdate update = store().BeginUpdate();
  EXPECT_EQ(ErrorCodeOf([&] { CompactMap(&store()); }), ErrorCode::kConflict);
}

TEST_P(MapVersions, ViewsShowWhatChanged) {
  if (GetParam() == testing::MapKind::kServer) {
    GTEST_SKIP() << "of files only";
  }
  Put(0, 1);
  Put(1, 2);
  Put(0, 3);
  Remove(1);
  EXPECT_THAT(
      RowsOf(path_,
             "SELECT version, kind, session, tiles_added, tiles_replaced, tiles_removed, "
             "num_tiles FROM v_versions ORDER BY version"),
      ElementsAre("1 | create |  | 0 | 0 | 0 | 0", "2 | ingest | place 0 | 1 | 0 | 0 | 1",
                  "3 | ingest | place 1 | 1 | 0 | 0 | 2", "4 | ingest | place 0 | 0 | 1 | 0 | 2",
                  "5 | remove | place 1 | 0 | 0 | 1 | 1"));
  EXPECT_THAT(RowsOf(path_,
                     "SELECT change, landmarks_before, landmarks_after, bytes_before > 0, "
                     "bytes_after > 0 FROM v_changes ORDER BY version"),
              ElementsAre("added | 0 | 20 | 0 | 1", "added | 0 | 20 | 0 | 1",
                          "replaced | 20 | 20 | 1 | 1", "removed | 20 | 0 | 1 | 0"));
}

// Random updates against a plain record of what each version held.
TEST_P(MapVersions, EveryVersionKeepsItsContent) {
  std::mt19937 random(3);
  std::map<int64_t, std::vector<std::string>> content_of_version;
  content_of_version[1] = ContentOf(path_);
  for (int step = 0; step < 60; ++step) {
    MapVersion version{};
    const int64_t latest = Value(store().Snapshot().version());
    switch (random() % 8) {
      case 0: {
        const auto back =
            std::next(content_of_version.begin(), random() % content_of_version.size());
        if (back->first == latest) {
          continue;
        }
        version = RollBack(MapVersion(back->first), &store());
        ASSERT_EQ(ContentOf(path_), back->second) << "step " << step;
        ASSERT_THAT(Diff(back->first, Value(version)), IsEmpty());
        break;
      }
      case 1:
        version = Prune({.keep = 12}, &store()).version;
        while (content_of_version.begin()->first < Value(version) - 11) {
          content_of_version.erase(content_of_version.begin());
        }
        break;
      case 2:
        version = Remove(static_cast<int>(random() % 5));
        break;
      default:
        version = Put(static_cast<int>(random() % 5), random() % 3);
    }
    content_of_version[Value(version)] = ContentOf(path_);
    if (step % 6 == 0) {
      ASSERT_THAT(store().Check({}).problems, IsEmpty()) << "step " << step;
    }
  }
  EXPECT_THAT(store().Check({}).problems, IsEmpty());
  const auto known = content_of_version;
  for (const auto& [version, content] : known) {
    if (version == Value(store().Snapshot().version())) {
      continue;
    }
    RollBack(MapVersion(version), &store());
    EXPECT_EQ(ContentOf(path_), content) << "version " << version;
  }
  EXPECT_THAT(store().Check({}).problems, IsEmpty());
}

}  // namespace
}  // namespace cairn
