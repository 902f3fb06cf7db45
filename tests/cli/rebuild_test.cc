// Tests archives that `cairn ingest` writes and the maps that `cairn rebuild` makes of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "cli/run_cairn.h"
#include "ingest/colmap/write_colmap.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* kVisits[] = {"monday", "tuesday", "wednesday"};

// One street as COLMAP saw it on three days. A map of the three, and their archive.
class Rebuild : public ::testing::Test {
 protected:
  Rebuild() {
    uint64_t seed = 1;
    for (const char* visit : kVisits) {
      StreetWorldOptions options;
      options.length_m = 24.0;
      options.num_landmarks = 300;
      options.view_seed = ++seed;
      const Reconstruction street = StreetWorld(options).Reconstruct();
      fs::create_directory(dir_.File(visit));
      WriteColmapModel(street, dir_.File(visit), ColmapModelFormat::kBinary);
      WriteColmapDatabase(street, dir_.File(visit) + "/database.db", {});
    }
    fs::create_directory(archive_);
    Run({"init", map_});
    for (const char* visit : kVisits) {
      Run(IngestOf(visit, map_, {"--archive", archive_}));
    }
  }

  std::vector<std::string> IngestOf(const std::string& visit, const std::string& map,
                                    const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {
        "ingest",         map,          "--model",
        dir_.File(visit), "--database", dir_.File(visit) + "/database.db",
        "--gps",          "--recorded", "2026-01-31T12:00:00Z"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  static std::string Run(const std::vector<std::string>& arguments) {
    const Finished finished = RunCairn(arguments);
    EXPECT_EQ(finished.exit_code, 0) << arguments[0] << ": " << finished.err;
    return finished.out;
  }

  void ExpectFails(const std::vector<std::string>& arguments, int exit_code,
                   const std::string& text) const {
    const std::string map = BytesOf(map_);
    const Finished finished = RunCairn(arguments);
    EXPECT_EQ(finished.exit_code, exit_code) << finished.err;
    EXPECT_THAT(finished.err, HasSubstr(text));
    EXPECT_TRUE(BytesOf(map_) == map);
    EXPECT_FALSE(fs::exists(again_));
    EXPECT_FALSE(fs::exists(again_ + ".unfinished"));
  }

  static std::string BytesOf(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }

  static std::string ContentOf(const std::string& map) {
    return Run({"sql", map, "--format", "csv",
                "SELECT tile, digest, num_landmarks FROM coverage JOIN cairn_tiles USING (tile_id) "
                "JOIN cairn_payloads USING (payload_id) ORDER BY tile"}) +
           Run({"sql", map, "--format", "csv",
                "SELECT session_id, name, recorded_at, content_digest FROM cairn_sessions "
                "ORDER BY session_id"}) +
           Run({"sql", map, "--format", "csv",
                "SELECT keyframe_id, session_id, tile_id, image_name, qw, tx_m FROM keyframes JOIN "
                "cairn_keyframe_poses USING (keyframe_id) ORDER BY keyframe_id"});
  }

  std::string FileOf(const std::string& visit) const {
    for (const auto& entry : fs::directory_iterator(archive_)) {
      if (entry.path().filename().string().find(visit) != std::string::npos) {
        return entry.path().string();
      }
    }
    return "";
  }

  static void FlipBit(const std::string& path, std::streamoff offset) {
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    const int byte = file.seekg(offset).get();
    file.seekp(offset).put(static_cast<char>(byte ^ 1));
  }

  const TempDir dir_;
  const std::string archive_ = dir_.File("archive");
  const std::string map_ = dir_.File("map.gpkg");
  const std::string again_ = dir_.File("again.gpkg");
};

TEST_F(Rebuild, IsTheMapToTheByte) {
  EXPECT_THAT(Run({"rebuild", again_, "--archive", archive_}), HasSubstr("3 sessions"));
  EXPECT_EQ(ContentOf(again_), ContentOf(map_));
  Run({"check", again_});
}

TEST_F(Rebuild, WithoutASessionIsTheMapThatNeverHadIt) {
  const std::string never = dir_.File("never.gpkg");
  Run({"init", never});
  Run(IngestOf("monday", never));
  Run(IngestOf("wednesday", never));
  EXPECT_THAT(Run({"remove", map_, "tuesday"}), HasSubstr("cairn rebuild --without"));
  EXPECT_NE(ContentOf(map_), ContentOf(never));
  Run({"rebuild", again_, "--archive", archive_, "--without", "tuesday"});
  EXPECT_EQ(ContentOf(again_), ContentOf(never));
}

TEST_F(Rebuild, ArchivesOptionsAndSessionsThatTheMapHasAlready) {
  const std::string other = dir_.File("other.gpkg");
  const std::string archive = dir_.File("other");
  fs::create_directory(archive);
  const std::vector<std::string> few = {"--max-descriptors", "300", "--code-bytes", "4"};
  std::vector<std::string> with_archive = few;
  with_archive.insert(with_archive.end(), {"--archive", archive});
  Run({"init", other});
  Run(IngestOf("monday", other, few));
  const std::string out = Run(IngestOf("tuesday", other, with_archive));
  EXPECT_THAT(out, HasSubstr("lacks sessions of the map: monday"));
  ExpectFails(IngestOf("monday", other, with_archive), 4,
              "has session 'tuesday' already, which came after 'monday'");
  fs::remove(archive + "/0001-tuesday.cairnsession");
  EXPECT_THAT(Run(IngestOf("monday", other, with_archive)), HasSubstr("0001-monday"));
  EXPECT_THAT(Run(IngestOf("tuesday", other, with_archive)), HasSubstr("0002-tuesday"));
  Run({"rebuild", again_, "--archive", archive});
  EXPECT_EQ(ContentOf(again_), ContentOf(other));
}

TEST_F(Rebuild, ArchivesTheCodebookThatTheMapHas) {
  const std::string other = dir_.File("other.gpkg");
  const std::string archive = dir_.File("other");
  fs::create_directory(archive);
  Run({"init", other});
  Run(IngestOf("monday", other, {"--codebook", "shipped"}));
  const Finished finished = RunCairn(IngestOf("monday", other, {"--archive", archive}));
  EXPECT_EQ(finished.exit_code, 4) << finished.err;
  EXPECT_THAT(finished.err, HasSubstr("--codebook shipped"));
  EXPECT_TRUE(fs::is_empty(archive));
  Run(IngestOf("monday", other, {"--codebook", "shipped", "--archive", archive}));
  Run({"rebuild", again_, "--archive", archive});
  EXPECT_EQ(ContentOf(again_), ContentOf(other));
}

TEST_F(Rebuild, AnArchiveOutlivesTheRemovalOfAllSessions) {
  for (const char* visit : kVisits) {
    Run({"remove", map_, visit});
  }
  EXPECT_THAT(Run(IngestOf("monday", map_, {"--archive", archive_})), HasSubstr("0004-monday"));
}

TEST_F(Rebuild, SaysWhatIsWrongWithItsInput) {
  const std::vector<std::string> rebuild = {"rebuild", again_, "--archive", archive_};
  ExpectFails({"rebuild", map_, "--archive", archive_}, 4, "already exists");
  ExpectFails({"rebuild", again_}, 2, "--archive");
  ExpectFails({"rebuild", again_, "--archive", dir_.File("none")}, 4, "no such folder");
  ExpectFails({"rebuild", again_, "--archive", map_}, 4, "this is a file");
  ExpectFails({"rebuild", again_, "--archive", archive_, "--without", "sunday"}, 4,
              "has no session 'sunday'");
  ExpectFails({"rebuild", again_, "--archive", archive_, "--without", "monday", "--without",
               "tuesday", "--without", "wednesday"},
              4, "has no session to make a map of");
  const std::string tuesday = FileOf("tuesday");
  fs::rename(tuesday, tuesday + ".unfinished");
  ExpectFails(rebuild, 4, "an ingest did not finish this file");
  fs::rename(tuesday + ".unfinished", dir_.File("away"));
  ExpectFails(rebuild, 4, "lacks session 'tuesday'");
  fs::rename(dir_.File("away"), tuesday);
  fs::copy_file(tuesday, archive_ + "/0002-copy.cairnsession");
  ExpectFails(rebuild, 4, "have one number");
}

TEST_F(Rebuild, SaysWhichFileIsDamaged) {
  const std::string tuesday = FileOf("tuesday");
  const auto size = static_cast<std::streamoff>(fs::file_size(tuesday));
  for (const std::streamoff offset : {std::streamoff{40}, size / 2}) {
    FlipBit(tuesday, offset);
    ExpectFails({"rebuild", again_, "--archive", archive_}, 5, tuesday);
    FlipBit(tuesday, offset);
  }
  fs::resize_file(tuesday, static_cast<uintmax_t>(size) / 2);
  ExpectFails({"rebuild", again_, "--archive", archive_}, 5, tuesday + ": ends too early");
  Run({"rebuild", again_, "--archive", archive_, "--without", "tuesday"});
}

TEST_F(Rebuild, AnArchiveBelongsToOneMap) {
  const std::string other = dir_.File("other.gpkg");
  Run({"init", other});
  ExpectFails(IngestOf("monday", other, {"--archive", archive_}), 4, "a folder of its own");
  EXPECT_EQ(Run({"sql", other, "--format", "csv", "SELECT count(*) AS n FROM cairn_sessions"}),
            "n\r\n0\r\n");
  ExpectFails(IngestOf("monday", other, {"--archive", dir_.File("none/below")}), 4, "mkdir");
}

}  // namespace
}  // namespace cairn::testing
