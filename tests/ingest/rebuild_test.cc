// Tests that maps of archived sessions are those that were ingested, to the byte.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "core/error.h"
#include "ingest/colmap/colmap_reader.h"
#include "ingest/ingest_session.h"
#include "ingest/maps/archive_folder.h"
#include "ingest/maps/archive_session.h"
#include "ingest/maps/rebuild_plan.h"
#include "ingest/maps/remove_session.h"
#include "ingest/place/georegister.h"
#include "support/map_builder.h"
#include "support/places.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"
#include "support/test_data.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using testing::ErrorCodeOf;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using Use = ArchiveFolder::Use;

struct Visit {
  std::string name;
  Reconstruction reconstruction;
  Sim3d ecef_from_world;
  std::string recorded_at;
  bool is_apart = false;
};

// One street at three times. The second visit takes more photos than the others.
std::vector<Visit> ThreeVisits() {
  std::vector<Visit> visits;
  for (const uint64_t seed : {2, 3, 4}) {
    testing::StreetWorldOptions options;
    options.length_m = 36.0;
    options.keyframe_step_m = seed == 3 ? 2.0 : 3.0;
    options.num_landmarks = 500;
    options.view_seed = seed;
    const testing::StreetWorld world(options);
    visits.push_back({"visit " + std::to_string(seed), world.Reconstruct(), world.EcefFromWorld(),
                      "2026-0" + std::to_string(seed) + "-01T12:00:00Z"});
  }
  return visits;
}

IngestOptions OptionsOf(const Visit& visit) {
  IngestOptions options;
  options.session_name = visit.name;
  options.recorded_at = visit.recorded_at;
  options.joining = visit.is_apart ? SessionJoining::kApart : SessionJoining::kJoin;
  options.codebook.max_training_descriptors = 1000;
  return options;
}

// Tiles by digest, sessions, keyframes and the codebook. The times of the versions are not the
// same.
std::vector<std::string> ContentOfMap(const std::string& path) {
  std::vector<std::string> content;
  for (const char* sql :
       {"SELECT c.tile, p.digest, c.num_landmarks, c.num_descriptors FROM cairn_tiles AS t "
        "JOIN coverage AS c USING (tile_id) JOIN cairn_payloads AS p USING (payload_id) "
        "ORDER BY c.tile",
        "SELECT session_id, name, source, recorded_at, content_digest, num_images, num_landmarks "
        "FROM cairn_sessions ORDER BY session_id",
        "SELECT k.keyframe_id, k.session_id, k.tile_id, k.image_name, k.lat_deg, k.heading_deg, "
        "p.qw, p.tx_m, c.params FROM keyframes AS k JOIN cairn_keyframe_poses AS p "
        "USING (keyframe_id) JOIN cairn_cameras AS c USING (camera_id) ORDER BY k.keyframe_id",
        "SELECT codebook_id, digest FROM cairn_codebooks"}) {
    for (std::string& row : testing::RowsOf(path, sql)) {
      content.push_back(std::move(row));
    }
  }
  return content;
}

class Rebuild : public ::testing::Test {
 protected:
  Rebuild() { fs::create_directory(archive_); }

  std::string NewMap(const std::string& name) const {
    MapStore::Create(dir_.File(name));
    return dir_.File(name);
  }

  static IngestReport Ingest(const Visit& visit, const std::string& map,
                             const BeforePublish& before_publish = {}) {
    MapStore store = MapStore::Open(map, OpenMode::kReadWrite);
    return IngestSession(visit.reconstruction, visit.ecef_from_world, OptionsOf(visit), &store, {},
                         before_publish);
  }

  void IngestAndArchive(const Visit& visit, const std::string& map) const {
    ArchiveFolder folder(archive_, Use::kIngest);
    Ingest(visit, map, [&](const PlannedSession& planned) {
      folder.Stage(MakeManifest(planned, visit.ecef_from_world, OptionsOf(visit), "{}"),
                   visit.reconstruction);
    });
    folder.Commit();
  }

  std::string RebuiltMap(const std::string& name, const std::vector<std::string>& without = {}) {
    const std::string map = NewMap(name);
    MapStore store = MapStore::Open(map, OpenMode::kReadWrite);
    const ArchiveFolder folder(archive_, Use::kRebuild);
    for (const ArchiveFile& file : PlanRebuild(folder, without)) {
      IngestAgain(ReadArchivedSession(file.path), OptionsOf({}),
                  without.empty() ? Numbering::kAsBefore : Numbering::kDense, &store, {});
    }
    EXPECT_THAT(store.Check({}).problems, IsEmpty());
    return map;
  }

  // Three visits with an archive; maps of all, and without the second.
  void ExpectExact(const std::vector<Visit>& visits) {
    const std::string map = NewMap("map.gpkg");
    const std::string without = NewMap("without.gpkg");
    for (const Visit& visit : visits) {
      IngestAndArchive(visit, map);
      if (&visit != &visits[1]) {
        Ingest(visit, without);
      }
    }
    EXPECT_EQ(ContentOfMap(RebuiltMap("again.gpkg")), ContentOfMap(map));
    EXPECT_EQ(ContentOfMap(RebuiltMap("again_without.gpkg", {visits[1].name})),
              ContentOfMap(without));
    MapStore store = MapStore::Open(map, OpenMode::kReadWrite);
    RemoveSession(visits[1].name, &store);
    EXPECT_EQ(ContentOfMap(RebuiltMap("removed.gpkg", {visits[1].name})), ContentOfMap(without));
    EXPECT_NE(ContentOfMap(map), ContentOfMap(without));  // What the removal could not undo.
  }

  void Recover(const std::string& map) const {
    ArchiveFolder(archive_, Use::kIngest)
        .Recover(ArchivedMapOf(MapStore::Open(map, OpenMode::kReadOnly).Snapshot()), "any");
  }

  std::vector<std::string> FilesInArchive() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(archive_)) {
      names.push_back(entry.path().filename().string());
    }
    std::ranges::sort(names);
    return names;
  }

  testing::TempDir dir_;
  const std::string archive_ = dir_.File("archive");
};

TEST_F(Rebuild, IsExactWithAndWithoutASession) { ExpectExact(ThreeVisits()); }

TEST_F(Rebuild, IsExactWithASessionThatIsKeptApart) {
  std::vector<Visit> visits = ThreeVisits();
  visits[2].is_apart = true;
  ExpectExact(visits);
}

TEST_F(Rebuild, OfKittiIsExactWithAndWithoutASession) {
  CAIRN_SKIP_WITHOUT_DATA("kitti_vo_2x51");
  const fs::path data = testing::TestDataDir() / "kitti_vo_2x51";
  ColmapInput input = {
      (data / "colmap_model_seq1").string(), (data / "database_seq1.db").string(), {}};
  std::vector<std::string> names;
  for (const ReconImage& image : ReadColmap(input).images) {
    names.push_back(image.name);
  }
  std::ranges::sort(names);
  std::vector<Visit> visits(3);
  for (size_t i = 0; i < visits.size(); ++i) {
    input.image_names.clear();
    for (size_t j = i; j < names.size(); j += visits.size()) {
      input.image_names.push_back(names[j]);
    }
    Visit& visit = visits[i];
    visit.name = "third " + std::to_string(i);
    visit.reconstruction = ReadColmap(input);
    visit.ecef_from_world =
        Georegister(visit.reconstruction, ReadCameraPositions((data / "georef_seq1.csv").string()),
                    {})
            .ecef_from_world;
    visit.recorded_at = "2026-0" + std::to_string(i + 1) + "-01T12:00:00Z";
  }
  ExpectExact(visits);
}

TEST_F(Rebuild, KeepsTimesOfTheClockAndGapsInTheIds) {
  std::vector<Visit> visits = ThreeVisits();
  visits[1].recorded_at = "";
  const std::string map = NewMap("map.gpkg");
  for (const Visit& visit : visits) {
    MapStore::Open(map, OpenMode::kReadWrite)
        .ReserveIds({.num_codebooks = 1,
                     .num_sessions = 2,
                     .num_keyframes = 30,
                     .num_landmarks = 400});  // As an ingest that was killed.
    IngestAndArchive(visit, map);
  }
  EXPECT_EQ(ContentOfMap(RebuiltMap("again.gpkg")), ContentOfMap(map));
}

TEST_F(Rebuild, OfAMapThatWasArchivedLaterIsExact) {
  const std::vector<Visit> visits = ThreeVisits();
  const std::string map = NewMap("map.gpkg");
  for (const Visit& visit : visits) {
    Ingest(visit, map);
  }
  const std::vector<std::string> content = ContentOfMap(map);
  for (const Visit& visit : visits) {
    IngestAndArchive(visit, map);
  }
  EXPECT_EQ(ContentOfMap(map), content);
  EXPECT_EQ(ContentOfMap(RebuiltMap("again.gpkg")), content);
}

TEST_F(Rebuild, ASessionThatCannotBeArchivedIsNotPublished) {
  const std::vector<Visit> visits = ThreeVisits();
  const std::string map = NewMap("map.gpkg");
  const auto code = ErrorCodeOf([&] {
    Ingest(visits[0], map,
           [](const PlannedSession&) { throw Error(ErrorCode::kIo, "the disk is full"); });
  });
  EXPECT_EQ(code, ErrorCode::kIo);
  EXPECT_EQ(MapStore::Open(map, OpenMode::kReadOnly).Snapshot().version(), MapVersion(1));
}

// The archive is on the disk when the version is published; the next ingest deletes what another
// update took away from it.
TEST_F(Rebuild, ASessionThatCannotBePublishedLeavesNoFileInTheEnd) {
  const std::vector<Visit> visits = ThreeVisits();
  const std::string map = NewMap("map.gpkg");
  const auto code = ErrorCodeOf([&] {
    ArchiveFolder folder(archive_, Use::kIngest);
    Ingest(visits[0], map, [&](const PlannedSession& planned) {
      folder.Stage(MakeManifest(planned, visits[0].ecef_from_world, OptionsOf(visits[0]), "{}"),
                   visits[0].reconstruction);
      EXPECT_THAT(FilesInArchive(), SizeIs(1));
      Ingest(visits[1], map);
    });
  });
  EXPECT_EQ(code, ErrorCode::kConflict);
  EXPECT_THAT(FilesInArchive(), ::testing::ElementsAre(::testing::EndsWith(".unfinished")));
  Recover(map);
  EXPECT_THAT(FilesInArchive(), IsEmpty());
}

// As when the connection to the database breaks while the server commits.
TEST_F(Rebuild, ASessionThatWasPublishedThoughTheIngestFailedKeepsItsFile) {
  const std::vector<Visit> visits = ThreeVisits();
  const std::string map = NewMap("map.gpkg");
  {
    ArchiveFolder folder(archive_, Use::kIngest);
    Ingest(visits[0], map, [&](const PlannedSession& planned) {
      folder.Stage(MakeManifest(planned, visits[0].ecef_from_world, OptionsOf(visits[0]), "{}"),
                   visits[0].reconstruction);
    });
  }  // Without ArchiveFolder::Commit.
  EXPECT_THAT(FilesInArchive(), ::testing::ElementsAre(::testing::EndsWith(".unfinished")));
  Recover(map);
  EXPECT_THAT(FilesInArchive(), ::testing::ElementsAre(::testing::EndsWith(".cairnsession")));
}

TEST_F(Rebuild, AnArchiveOutlivesTheRemovalOfAllSessions) {
  const std::vector<Visit> visits = ThreeVisits();
  const std::string map = NewMap("map.gpkg");
  IngestAndArchive(visits[0], map);
  {
    MapStore store = MapStore::Open(map, OpenMode::kReadWrite);
    RemoveSession(visits[0].name, &store);
  }
  Recover(map);
  IngestAndArchive(visits[1], map);
  EXPECT_THAT(FilesInArchive(), SizeIs(2));
}

TEST_F(Rebuild, AKillAfterThePublicationKeepsTheFile) {
  const std::vector<Visit> visits = ThreeVisits();
  const std::string map = NewMap("map.gpkg");
  IngestAndArchive(visits[0], map);
  const std::string file = FilesInArchive().at(0);
  fs::rename(archive_ + "/" + file, archive_ + "/" + file + ".unfinished");
  Recover(map);
  EXPECT_THAT(FilesInArchive(), ::testing::ElementsAre(file));
  // The same session of another ingest has other ids.
  fs::rename(archive_ + "/" + file, archive_ + "/" + file + ".unfinished");
  MapStore store = MapStore::Open(map, OpenMode::kReadWrite);
  RemoveSession(visits[0].name, &store);
  Ingest(visits[0], map);
  Recover(map);
  EXPECT_THAT(FilesInArchive(), IsEmpty());
}

TEST_F(Rebuild, RefusesContentThatIsNotThatOfItsDigest) {
  const std::vector<Visit> visits = ThreeVisits();
  IngestAndArchive(visits[0], NewMap("map.gpkg"));
  const ArchiveFolder folder(archive_, Use::kRebuild);
  ArchivedSession session = ReadArchivedSession(folder.files().at(0).path);
  session.reconstruction.images[0].name = "another";
  MapStore store = MapStore::Create(dir_.File("again.gpkg"));
  EXPECT_EQ(
      ErrorCodeOf([&] { IngestAgain(session, OptionsOf({}), Numbering::kAsBefore, &store, {}); }),
      ErrorCode::kMapDamaged);
  EXPECT_EQ(store.Snapshot().version(), MapVersion(1));
}

}  // namespace
}  // namespace cairn
