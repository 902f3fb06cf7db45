// Tests maps whose pages refer to each other so often that the scan of a table would never end. All
// readers must end, with Error(kMapDamaged) or at their time limit. A test that hangs has failed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>

#include "core/error.h"
#include "storage/map/map_store.h"
#include "storage/map/sql_shell.h"
#include "support/map_builder.h"
#include "support/raw_sql.h"
#include "support/street_map.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using testing::ErrorCodeOf;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr int kNumCells = 200;
constexpr int kNumLevels = 12;

void Put16(std::string* page, size_t at, uint32_t value) {
  (*page)[at] = static_cast<char>(value >> 8);
  (*page)[at + 1] = static_cast<char>(value);
}

void Put32(std::string* page, size_t at, uint32_t value) {
  Put16(page, at, value >> 16);
  Put16(page, at + 2, value & 0xffff);
}

uint32_t Get32(const std::string& bytes, size_t at) {
  uint32_t value = 0;
  for (size_t i = 0; i < 4; ++i) {
    value = value << 8 | static_cast<uint8_t>(bytes[at + i]);
  }
  return value;
}

// An interior page of a table whose cells all point to `child`.
std::string InteriorPage(size_t page_size, uint32_t child) {
  constexpr size_t kHeaderSize = 12, kCellSize = 6;
  std::string page(page_size, '\0');
  page[0] = 5;
  Put16(&page, 3, kNumCells);
  Put16(&page, 5, static_cast<uint32_t>(page_size - kNumCells * kCellSize));
  Put32(&page, 8, child);
  for (int i = 0; i < kNumCells; ++i) {
    const size_t cell = page_size - (i + 1) * kCellSize;
    Put16(&page, kHeaderSize + 2 * i, static_cast<uint32_t>(cell));
    Put32(&page, cell, child);
    page[cell + 4] = static_cast<char>(0x80 | i >> 7);  // The key, as a varint of two bytes.
    page[cell + 5] = static_cast<char>(i & 0x7f);
  }
  return page;
}

// Puts levels of interior pages between the root of a table and its rows. Each points to the next
// two hundred times, so that the rows come 200^12 times.
void MakeEndless(const std::string& path, int64_t root_page) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  in.close();
  constexpr size_t kPageSize = 16384;
  const size_t root = static_cast<size_t>(root_page - 1) * kPageSize;
  const std::string leaf = bytes.substr(root, kPageSize);
  ASSERT_EQ(leaf[0], 13) << "the root is no leaf";
  auto next_page = static_cast<uint32_t>(bytes.size() / kPageSize) + 1;
  bytes.replace(root, kPageSize, InteriorPage(kPageSize, next_page));
  for (int level = 1; level < kNumLevels; ++level) {
    bytes += InteriorPage(kPageSize, ++next_page);
  }
  bytes += leaf;
  constexpr size_t kChangeCounter = 24, kPageCount = 28, kCountIsValidFor = 92;
  Put32(&bytes, kPageCount, next_page);
  Put32(&bytes, kCountIsValidFor, Get32(bytes, kChangeCounter));
  std::ofstream(path, std::ios::binary) << bytes;
}

class EndlessMap : public ::testing::TestWithParam<const char*> {
 protected:
  EndlessMap() : path_(testing::MakeStreetMap(dir_.File("a.gpkg"))) {
    std::string root_page;
    SqlSink sink;
    sink.on_columns = [](const std::vector<std::string>&) {};
    sink.on_row = [&](const std::vector<SqlCell>& row) { root_page = row.at(0).text; };
    RunSql(path_,
           std::string("SELECT rootpage FROM sqlite_schema WHERE name = '") + GetParam() + "'", {},
           sink);
    MakeEndless(path_, std::stoll(root_page));
  }

  testing::TempDir dir_;
  std::string path_;
};

TEST_P(EndlessMap, ChecksEndWithAProblem) {
  EXPECT_THAT(MapStore::Open(path_, OpenMode::kReadOnly).Check({}).problems, Not(IsEmpty()));
}

// What a server, `info` and `ingest` read; some of it may not touch the table.
TEST_P(EndlessMap, ReadersAndWritersEnd) {
  const auto is_damage = [](std::optional<ErrorCode> code) {
    return !code || *code == ErrorCode::kMapDamaged;
  };
  MapStore store = MapStore::Open(path_, OpenMode::kReadWrite);
  const MapSnapshot snapshot = store.Snapshot();
  EXPECT_PRED1(is_damage, ErrorCodeOf([&] { snapshot.Info(); }));
  EXPECT_PRED1(is_damage, ErrorCodeOf([&] { snapshot.Sessions(); }));
  EXPECT_PRED1(is_damage, ErrorCodeOf([&] { snapshot.AllTiles(1000); }));
  EXPECT_PRED1(is_damage, ErrorCodeOf([&] { snapshot.FindTiles({-2.0, -4.0, 2.0, 4.0}); }));
  EXPECT_PRED1(is_damage, ErrorCodeOf([&] { snapshot.KeyframesOfSession(SessionId(1)); }));
  EXPECT_PRED1(is_damage, ErrorCodeOf([&] { snapshot.CurrentCodebook(); }));
  EXPECT_PRED1(is_damage, ErrorCodeOf([&] {
                 MapUpdate update = store.BeginUpdate();
                 update.RemoveSession(SessionId(1));
                 update.Publish();
               }));
}

// Counting rows is what SQLite does without asking its progress handler.
TEST_P(EndlessMap, SqlEndsAtItsTimeLimit) {
  for (const char* query : {"SELECT count(*) FROM ", "SELECT max(rowid + 0) FROM "}) {
    EXPECT_EQ(ErrorCodeOf([&] {
                RunSql(path_, std::string(query) + GetParam() + " NOT INDEXED", {.timeout_s = 0.2},
                       {[](auto&) {}, [](auto&) {}});
              }),
              ErrorCode::kBadInput);
  }
}

INSTANTIATE_TEST_SUITE_P(Tables, EndlessMap,
                         ::testing::Values("keyframes", "coverage", "cairn_sessions",
                                           "cairn_cameras", "cairn_keyframe_poses", "cairn_tiles",
                                           "rtree_coverage_geom_rowid", "rtree_keyframes_geom_node",
                                           "gpkg_contents", "cairn_versions"),
                         [](const auto& table) { return std::string(table.param); });

// Nodes of an R*Tree are found by number: here the root is its own child, forty levels deep.
TEST(EndlessRTree, SearchesChecksAndUpdatesEnd) {
  const testing::TempDir dir;
  const std::string path = testing::MakeStreetMap(dir.File("a.gpkg"));
  std::string node = "00280032";  // Forty levels, fifty cells: node 1, from -360 to 360 degrees.
  for (int i = 0; i < 50; ++i) {
    node += "0000000000000001C3B4000043B40000C3B4000043B40000";
  }
  constexpr size_t kNodeBytes = 4 + 51 * 24;
  node.resize(2 * kNodeBytes, '0');
  testing::ExecuteRaw(
      path, "UPDATE rtree_coverage_geom_node SET data = x'" + node + "' WHERE nodeno = 1");
  MapStore store = MapStore::Open(path, OpenMode::kReadWrite);
  const auto search = [&] { store.Snapshot().FindTiles({-2.0, -4.0, 2.0, 4.0}); };
  EXPECT_EQ(ErrorCodeOf(search), ErrorCode::kMapDamaged);
  EXPECT_THAT(store.Check({}).problems, Not(IsEmpty()));
  EXPECT_EQ(ErrorCodeOf([&] {
              MapUpdate update = store.BeginUpdate();
              update.RemoveTile(store.Snapshot().AllTiles(1)[0].tile_id);
              update.Publish();
            }),
            ErrorCode::kMapDamaged);
}

// A keyframe of the past that changed in each of twelve thousand versions. A check that looks for
// each of its poses among all of them works longer than a file of this size allows.
TEST(MapOfManyVersions, IsNotTakenForEndless) {
  const testing::TempDir dir;
  const std::string path = testing::MakeStreetMap(dir.File("a.gpkg"));
  {
    MapStore store = MapStore::Open(path, OpenMode::kReadWrite);
    MapUpdate update = store.BeginUpdate();
    update.RemoveTile(store.Snapshot().AllTiles(1)[0].tile_id);
    update.RemoveKeyframe(KeyframeId(1));
    update.Publish();
  }
  const std::string later =
      "WITH RECURSIVE later (version) AS (SELECT 3 UNION ALL "
      "SELECT version + 1 FROM later WHERE version < 12000) ";
  testing::ExecuteRaw(
      path,
      "UPDATE cairn_versions SET version = 12001 WHERE version = 3;"
      "UPDATE cairn_past_tiles SET until = 12001;" +
          later +
          "INSERT INTO cairn_versions SELECT l.version, created_at, author, kind, session, "
          "summary, codebook_id, num_sessions, num_keyframes, num_tiles, num_landmarks, "
          "num_descriptors, payload_bytes, south_deg, west_deg, north_deg, east_deg "
          "FROM cairn_versions AS v CROSS JOIN later AS l WHERE v.version = 2;" +
          later +
          "INSERT INTO cairn_past_keyframes SELECT keyframe_id, l.version, l.version + 1, "
          "session_id, tile_id, image_name, camera_id, qw, qx, qy, qz, tx_m, ty_m, tz_m "
          "FROM cairn_past_keyframes CROSS JOIN later AS l");
  EXPECT_THAT(MapStore::Open(path, OpenMode::kReadOnly).Check({}).problems, IsEmpty());
}

TEST(SqlTimeLimit, StopsAQueryThatNeverEnds) {
  const testing::TempDir dir;
  const std::string path = testing::MakeStreetMap(dir.File("a.gpkg"));
  EXPECT_EQ(ErrorCodeOf([&] {
              RunSql(path,
                     "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) "
                     "SELECT count(*) FROM n",
                     {.timeout_s = 0.2}, {[](auto&) {}, [](auto&) {}});
            }),
            ErrorCode::kBadInput);
  EXPECT_EQ(ErrorCodeOf([&] { RunSql(path, "SELECT 1", {.timeout_s = 0.0}, {}); }),
            ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace cairn
