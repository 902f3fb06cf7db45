// Tests MapStore::Open on files that are not sound maps, and the content of a map after an
// interrupted write.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "core/error.h"
#include "storage/map/map_store.h"
#include "storage/tile/tile_codec.h"
#include "support/map_builder.h"
#include "support/raw_sql.h"
#include "support/street_map.h"
#include "support/temp_dir.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

using testing::ErrorCodeOf;
using testing::ExecuteRaw;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::MakeStreetMap;
using testing::TempDir;

std::string ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string WriteFile(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

void ExpectRefused(const std::string& path, ErrorCode code, const std::string& text) {
  for (const OpenMode mode : {OpenMode::kReadOnly, OpenMode::kReadWrite}) {
    try {
      MapStore::Open(path, mode);
      ADD_FAILURE() << path << " was opened";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      EXPECT_THAT(error.what(), HasSubstr(text));
      EXPECT_THAT(error.what(), HasSubstr(path));
    }
  }
}

// Reads everything a map has.
void ReadAll(const MapStore& store) {
  const MapSnapshot snapshot = store.Snapshot();
  snapshot.Info();
  snapshot.FindTiles({-2.0, -4.0, 2.0, 4.0});
  for (const TileRecord& tile : snapshot.AllTiles(1000)) {
    DecodeTile(snapshot.LoadPayload(tile.payload_id));
    snapshot.LoadCodebook(tile.codebook_id);
  }
  for (const SessionRecord& session : snapshot.Sessions()) {
    snapshot.KeyframesOfSession(session.id);
  }
}

// The size that is in the header of an SQLite file.
size_t PageSize(const std::string& path) {
  const std::string head = ReadFile(path).substr(0, 18);
  return static_cast<unsigned char>(head[16]) * 256u + static_cast<unsigned char>(head[17]);
}

TEST(MapFile, PagesAreLargeAndOthersAreReadAndWritten) {
  const TempDir dir;
  const std::string path = MakeStreetMap(dir.File("map.gpkg"));
  EXPECT_EQ(PageSize(path), 16384u);
  const std::vector<TileRecord> tiles =
      MapStore::Open(path, OpenMode::kReadOnly).Snapshot().AllTiles(9);
  ExecuteRaw(path, "PRAGMA journal_mode = DELETE; PRAGMA page_size = 4096; VACUUM");
  ASSERT_EQ(PageSize(path), 4096u);
  MapStore store = MapStore::Open(path, OpenMode::kReadWrite);
  ReadAll(store);
  MapUpdate update = store.BeginUpdate();
  update.RemoveTile(tiles.front().tile_id);
  update.Publish();
  EXPECT_EQ(store.Snapshot().AllTiles(9).size(), tiles.size() - 1);
  EXPECT_THAT(store.Check({}).problems, IsEmpty());
}

TEST(MapFile, ForeignFilesAreNamedForWhatTheySeemToBe) {
  const TempDir dir;
  ExpectRefused(dir.File("none.gpkg"), ErrorCode::kNotFound, "cairn init");
  ExpectRefused(dir.path().string(), ErrorCode::kBadInput, "directory");
  ExpectRefused(WriteFile(dir.File("a"), "image,lat,lon\n"), ErrorCode::kBadInput, "a text file");
  ExpectRefused(WriteFile(dir.File("b"), "\x89PNG\r\n"), ErrorCode::kBadInput, "a PNG image");
  ExpectRefused(WriteFile(dir.File("c"), ""), ErrorCode::kBadInput, "an empty file");
  ExpectRefused(WriteFile(dir.File("d"), std::string(200, '\1')), ErrorCode::kBadInput,
                "an unknown binary file");
  ExpectRefused("/dev/null", ErrorCode::kBadInput, "not a regular file");
}

TEST(MapFile, ForeignDatabasesAreNamedForWhatTheySeemToBe) {
  const TempDir dir;
  ExecuteRaw(dir.File("a.db"), "CREATE TABLE t (x)");
  ExpectRefused(dir.File("a.db"), ErrorCode::kBadInput, "SQLite database of another program");
  ExecuteRaw(dir.File("b.db"), "CREATE TABLE keypoints (x); CREATE TABLE descriptors (x)");
  ExpectRefused(dir.File("b.db"), ErrorCode::kBadInput, "COLMAP database");
  ExecuteRaw(dir.File("c.gpkg"), "CREATE TABLE t (x); PRAGMA application_id = 0x47504B47");
  ExpectRefused(dir.File("c.gpkg"), ErrorCode::kBadInput, "GeoPackage of another program");
}

TEST(MapFile, AMapOfANewerFormatAsksForANewerCairn) {
  const TempDir dir;
  const std::string path = MakeStreetMap(dir.File("a.gpkg"));
  ExecuteRaw(path, "UPDATE cairn_map SET format_version = 7");
  ReadAll(MapStore::Open(path, OpenMode::kReadOnly));  // Its oldest reader is still 1.
  ExecuteRaw(path, "UPDATE cairn_map SET oldest_reader_version = 2");
  ExpectRefused(path, ErrorCode::kConflict, "use a newer Cairn");
}

TEST(MapFile, MissingTablesAndColumnsAreDamage) {
  const TempDir dir;
  const std::string path = MakeStreetMap(dir.File("a.gpkg"));
  ExecuteRaw(path,
             "PRAGMA writable_schema = ON; DELETE FROM sqlite_schema WHERE name = 'cairn_tiles'");
  EXPECT_EQ(ErrorCodeOf([&] { ReadAll(MapStore::Open(path, OpenMode::kReadOnly)); }),
            ErrorCode::kMapDamaged);
  const std::string renamed = MakeStreetMap(dir.File("b.gpkg"));
  ExecuteRaw(renamed, "ALTER TABLE cairn_keyframe_poses RENAME COLUMN qw TO w");
  ExpectRefused(renamed, ErrorCode::kMapDamaged, "cairn_keyframe_poses");
  const std::string empty = MakeStreetMap(dir.File("c.gpkg"));
  ExecuteRaw(empty, "DELETE FROM cairn_map");
  ExpectRefused(empty, ErrorCode::kMapDamaged, "cairn_map is empty");
}

TEST(MapFile, ATruncatedMapIsDamaged) {
  const TempDir dir;
  const std::string whole = ReadFile(MakeStreetMap(dir.File("a.gpkg")));
  std::vector<size_t> sizes = {1, 15, 16, 99, 100, 500};
  for (size_t size = 1000; size < whole.size(); size += 4001) {
    sizes.push_back(size);
  }
  for (const size_t size : sizes) {
    const std::string path = WriteFile(dir.File("b.gpkg"), whole.substr(0, size));
    EXPECT_EQ(ErrorCodeOf([&] { ReadAll(MapStore::Open(path, OpenMode::kReadOnly)); }),
              ErrorCode::kMapDamaged)
        << size << " of " << whole.size();
  }
}

TEST(MapFile, FlippedBitsAreDamageOrHarmless) {
  const TempDir dir;
  const std::string whole = ReadFile(MakeStreetMap(dir.File("a.gpkg")));
  const std::string path = dir.File("b.gpkg");
  int num_refused = 0;
  std::mt19937 random(1);
  for (int trial = 0; trial < 300; ++trial) {
    std::string flipped = whole;
    // The first hundred in the header and the schema, the rest anywhere.
    const size_t bit = random() % (8 * (trial < 100 ? 4096 : whole.size()));
    flipped[bit / 8] ^= static_cast<char>(1 << bit % 8);
    WriteFile(path, flipped);
    const std::optional<ErrorCode> code =
        ErrorCodeOf([&] { ReadAll(MapStore::Open(path, OpenMode::kReadOnly)); });
    num_refused += code.has_value() ? 1 : 0;
    // A flipped format number is a conflict, a flipped name or id may be "not found".
    EXPECT_TRUE(!code || *code == ErrorCode::kMapDamaged || *code == ErrorCode::kConflict ||
                *code == ErrorCode::kNotFound || *code == ErrorCode::kBadInput)
        << "bit " << bit << ": " << ErrorCodeName(*code);
  }
  EXPECT_GT(num_refused, 10);
}

TEST(MapFile, CheckFindsAFlippedBitInAPayload) {
  const TempDir dir;
  const std::string path = MakeStreetMap(dir.File("a.gpkg"));
  std::string bytes = ReadFile(path);
  const size_t magic = bytes.find("CTIL");
  ASSERT_NE(magic, std::string::npos);
  bytes[magic + 300] ^= 1;
  WriteFile(path, bytes);
  std::vector<int64_t> done;
  const CheckReport report =
      MapStore::Open(path, OpenMode::kReadOnly).Check([&done](int64_t num_done, int64_t) {
        done.push_back(num_done);
      });
  EXPECT_THAT(done, ::testing::ElementsAre(1, 2, 3));
  EXPECT_EQ(report.num_tiles_checked, 3);
  ASSERT_EQ(report.problems.size(), 1u);
  EXPECT_THAT(report.problems[0], HasSubstr("checksum"));
}

TEST(MapFile, CheckFindsRowsThatDoNotAgree) {
  const TempDir dir;
  const std::string path = MakeStreetMap(dir.File("a.gpkg"));
  ExecuteRaw(path,
             "UPDATE coverage SET num_landmarks = num_landmarks + 1;"
             "DELETE FROM rtree_coverage_geom;"
             "DELETE FROM cairn_keyframe_poses WHERE keyframe_id = 1;"
             "INSERT INTO cairn_payloads (digest, bytes) VALUES (printf('%032d', 0), x'00');");
  const CheckReport report = MapStore::Open(path, OpenMode::kReadOnly).Check({});
  EXPECT_THAT(report.problems,
              ::testing::IsSupersetOf({HasSubstr("3 tiles are missing in the spatial index"),
                                       HasSubstr("1 keyframes have no pose"),
                                       HasSubstr("1 payloads belong to no tile"),
                                       HasSubstr("its counts do not match its payload")}));
}

TEST(MapFile, AKilledWriterLeavesTheMapAsItWas) {
  const TempDir dir;
  const std::string path = MakeStreetMap(dir.File("a.gpkg"));
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    MapStore store = MapStore::Open(path, OpenMode::kReadWrite);
    MapUpdate update = store.BeginUpdate();
    const std::vector<uint8_t> noise(4 << 20, 7);  // More than the page cache: reaches the log.
    for (const TileRecord& tile : store.Snapshot().AllTiles(10)) {
      update.PutTile(tile, noise);
    }
    update.RemoveSession(SessionId(1));
    const char done = 1;
    if (write(ready[1], &done, 1) == 1) {
      pause();
    }
    _exit(1);
  }
  char done = 0;
  ASSERT_EQ(read(ready[0], &done, 1), 1);
  ASSERT_EQ(kill(child, SIGKILL), 0);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  close(ready[0]);
  close(ready[1]);
  EXPECT_GT(std::filesystem::file_size(path + "-wal"), 1u << 20);

  MapStore store = MapStore::Open(path, OpenMode::kReadWrite);
  ReadAll(store);
  EXPECT_THAT(store.Check({}).problems, IsEmpty());
  const MapSnapshot snapshot = store.Snapshot();
  EXPECT_EQ(snapshot.version(), MapVersion(2));
  EXPECT_EQ(snapshot.Sessions().size(), 2u);
  EXPECT_EQ(store.BeginUpdate().Publish(), MapVersion(3));  // The lock died with its holder.
}

// Runs `action` in a child process of a user who owns nothing; root may write everywhere.
int ExitStatusAsNobody(const std::function<int()>& action) {
  constexpr uid_t kNobody = 65534;
  const pid_t child = fork();
  if (child == 0) {
    if (geteuid() == 0 && setuid(kNobody) != 0) {
      _exit(100);
    }
    _exit(action());
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(MapFile, ReadsAMapInADirectoryThatCannotBeWritten) {
  const TempDir dir;
  const std::string path = MakeStreetMap(dir.File("a#1?.gpkg"));
  chmod(path.c_str(), 0444);
  chmod(dir.path().c_str(), 0555);
  const int status = ExitStatusAsNobody([&] {
    const auto code = ErrorCodeOf([&] {
      const MapStore store = MapStore::Open(path, OpenMode::kReadOnly);
      ReadAll(store);
      const MapSnapshot first = store.Snapshot();
      const MapSnapshot second = store.Snapshot();
    });
    return code ? 1 + static_cast<int>(*code) : 0;
  });
  const int update_status = ExitStatusAsNobody([&] {
    const auto code =
        ErrorCodeOf([&] { MapStore::Open(path, OpenMode::kReadWrite).BeginUpdate().Publish(); });
    return code ? 1 + static_cast<int>(*code) : 0;
  });
  chmod(dir.path().c_str(), 0755);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(update_status, 1 + static_cast<int>(ErrorCode::kIo));
}

}  // namespace
}  // namespace cairn
