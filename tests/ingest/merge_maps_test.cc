#include "ingest/maps/merge_maps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/error.h"
#include "support/places.h"
#include "support/temp_dir.h"
#include "support/whole_versions.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using testing::ErrorCodeOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::PutPlace;
using testing::RowsOf;
using testing::TileOfPlace;

// Makes a map of the places [first, last], whose sessions are named with the prefix.
MapStore MakePlaces(const fs::path& path, int first, int last, const std::string& prefix) {
  MapStore store = MapStore::Create(path.string());
  MapUpdate update = store.BeginUpdate();
  for (int place = first; place <= last; ++place) {
    PutPlace(place, place, &update, 30, prefix);
  }
  update.Publish();
  return store;
}

class MergedMap : public ::testing::Test {
 protected:
  void ExpectRefused(const MapStore& b, ErrorCode code, const std::string& text) {
    try {
      MergeMaps(a_, b, to_, {}, {});
      FAIL() << "was merged";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code);
      EXPECT_THAT(error.what(), HasSubstr(text));
    }
    EXPECT_FALSE(fs::exists(to_));
  }

  testing::TempDir dir_;
  const std::string to_ = dir_.File("c.gpkg");
  MapStore a_ = MakePlaces(dir_.path() / "a.gpkg", 0, 2, "a ");
};

TEST_F(MergedMap, HoldsBothMaps) {
  const MapStore b = MakePlaces(dir_.path() / "b.gpkg", 2, 4, "b ");
  std::vector<int64_t> done;
  const MergeReport report =
      MergeMaps(a_, b, to_, {}, [&done](int64_t num_done, int64_t) { done.push_back(num_done); });
  EXPECT_EQ(report.num_tiles_of_both, 1);
  EXPECT_EQ(report.totals.num_tiles, 5);
  EXPECT_EQ(report.totals.num_sessions, 6);
  EXPECT_EQ(report.totals.num_keyframes, 12);
  EXPECT_EQ(report.totals.num_landmarks, 180);
  EXPECT_THAT(done, ElementsAre(1, 2, 3, 4, 5));
  const MapStore merged = MapStore::Open(to_, OpenMode::kReadOnly);
  EXPECT_THAT(merged.Check({}).problems, IsEmpty());
  EXPECT_EQ(merged.Snapshot().FindTile(TileOfPlace(2))->num_landmarks, 60);
  EXPECT_THAT(RowsOf(to_, "SELECT count(*), count(DISTINCT landmark_id) FROM cairn_landmarks"),
              ElementsAre("180 | 180"));
  EXPECT_THAT(RowsOf(to_, "SELECT name FROM cairn_sessions ORDER BY session_id"),
              ElementsAre("a 0", "a 1", "a 2", "b 2", "b 3", "b 4"));
  EXPECT_THAT(RowsOf(to_, "SELECT count(*) FROM cairn_codebooks"), ElementsAre("1"));
  EXPECT_EQ(merged.Snapshot().Versions(1)[0].summary, "a.gpkg, version 2 and b.gpkg, version 2");
}

TEST_F(MergedMap, KeepsPositionsAndDescriptors) {
  const MapStore b = MakePlaces(dir_.path() / "b.gpkg", 2, 4, "b ");
  MergeMaps(a_, b, to_, {}, {});
  const std::string landmarks =
      "SELECT x_m, y_m, z_m, sigma_m, num_descriptors, num_keyframes FROM cairn_landmarks "
      "WHERE tile = '" +
      TileOfPlace(4).ToString() + "' ORDER BY x_m, y_m, z_m";
  EXPECT_EQ(RowsOf(to_, landmarks), RowsOf(b.path(), landmarks));
  EXPECT_EQ(RowsOf(to_, landmarks).size(), 30u);
}

TEST_F(MergedMap, WithAnEmptyMapIsTheOther) {
  const MapStore empty = MapStore::Create(dir_.File("b.gpkg"));
  EXPECT_EQ(MergeMaps(empty, a_, to_, {}, {}).totals.num_landmarks, 90);
  EXPECT_THAT(MapStore::Open(to_, OpenMode::kReadOnly).Check({}).problems, IsEmpty());
}

TEST_F(MergedMap, OfTwoCodebooksIsRefused) {
  MapStore b = MapStore::Create(dir_.File("b.gpkg"));
  MapUpdate update = b.BeginUpdate();
  update.AddCodebook(testing::RandomCodebook({.seed = 2}));
  update.Publish();
  ExpectRefused(b, ErrorCode::kConflict, "run `cairn recode ");
}

TEST_F(MergedMap, OfTwoKindsOfDescriptorsIsRefused) {
  MapStore b = MapStore::Create(dir_.File("b.gpkg"));
  Codebook codebook = testing::RandomCodebook();
  codebook.descriptor_type = "superpoint";
  MapUpdate update = b.BeginUpdate();
  update.AddCodebook(codebook);
  update.Publish();
  ExpectRefused(b, ErrorCode::kBadInput, "'superpoint'");
}

TEST_F(MergedMap, OfSessionsOfOneNameIsRefused) {
  const MapStore b = MakePlaces(dir_.path() / "b.gpkg", 1, 1, "a ");
  ExpectRefused(b, ErrorCode::kConflict, "both have a session 'a 1'");
}

TEST_F(MergedMap, OfOneRecordingUnderTwoNamesIsRefused) {
  MapStore b = MapStore::Create(dir_.File("b.gpkg"));
  SessionRecord session;
  session.content_digest = "12ab";
  for (MapStore* store : {&a_, &b}) {
    MapUpdate update = store->BeginUpdate();
    session.name = store->path();
    update.AddSession(session);
    update.Publish();
  }
  ExpectRefused(b, ErrorCode::kConflict, "are the same recording");
}

TEST_F(MergedMap, OfOneRecordingThatWasPlacedTwiceIsRefused) {
  MapStore b = MapStore::Create(dir_.File("b.gpkg"));
  for (MapStore* store : {&a_, &b}) {
    SessionRecord session;
    session.name = store->path();
    session.content_digest = std::string(32, '7') + std::string(16, store == &b ? '1' : '2');
    MapUpdate update = store->BeginUpdate();
    update.AddSession(session);
    update.Publish();
  }
  ExpectRefused(b, ErrorCode::kConflict, "are the same recording");
}

TEST_F(MergedMap, IsNotMadeOverAnother) {
  const MapStore b = MapStore::Create(dir_.File("b.gpkg"));
  EXPECT_EQ(ErrorCodeOf([&] { MergeMaps(a_, b, b.path(), {}, {}); }), ErrorCode::kConflict);
}

const testing::MapOperation kMerge = {
    {"a.gpkg", "b.gpkg", "c.gpkg"},
    [](const fs::path& folder) {
      MakePlaces(folder / "a.gpkg", 0, 2, "a ");
      MakePlaces(folder / "b.gpkg", 2, 4, "b ");
    },
    [](const fs::path& folder) {
      const MapStore a = MapStore::Open((folder / "a.gpkg").string(), OpenMode::kReadWrite);
      const MapStore b = MapStore::Open((folder / "b.gpkg").string(), OpenMode::kReadWrite);
      MergeMaps(a, b, (folder / "c.gpkg").string(), {}, {});
    }};

TEST(MergeFaults, KillsLeaveNoHalfMap) { testing::ExpectWholeVersionsAfterKills(kMerge, 34); }
TEST(MergeFaults, FullDisksLeaveNoHalfMap) { testing::ExpectWholeVersionsOnFullDisks(kMerge, 8); }

}  // namespace
}  // namespace cairn
