#include "storage/map/sql_shell.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "core/error.h"
#include "support/map_builder.h"
#include "support/street_map.h"
#include "support/temp_dir.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

using ::testing::ElementsAre;
using testing::ErrorCodeOf;
using ::testing::Gt;
using ::testing::HasSubstr;
using testing::MakeStreetMap;
using ::testing::SizeIs;
using testing::TempDir;

struct Result {
  std::vector<std::string> columns;
  std::vector<std::vector<SqlCell>> rows;
};

// The result of the last statement that gives one.
Result Query(const std::string& path, const std::string& sql) {
  Result result;
  SqlSink sink;
  sink.on_columns = [&](const std::vector<std::string>& names) { result = {names, {}}; };
  sink.on_row = [&](const std::vector<SqlCell>& row) { result.rows.push_back(row); };
  RunSql(path, sql, {}, sink);
  return result;
}

std::string Value(const std::string& path, const std::string& sql) {
  const Result result = Query(path, sql);
  return result.rows.empty() ? "no rows" : result.rows.at(0).at(0).text;
}

// The texts between ```sql and ``` of a Markdown file.
std::vector<std::string> SqlBlocks(const std::string& path) {
  std::ifstream file(path);
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  constexpr std::string_view kBegin = "```sql\n", kEnd = "```";
  std::vector<std::string> blocks;
  for (size_t at = text.find(kBegin); at != std::string::npos; at = text.find(kBegin, at)) {
    at += kBegin.size();
    const size_t end = text.find(kEnd, at);
    blocks.push_back(text.substr(at, end - at));
    at = end + kEnd.size();
  }
  return blocks;
}

TEST(SqlShell, EveryQueryOfTheReadmeFindsSomething) {
  const TempDir dir;
  const std::string path = MakeStreetMap(dir.File("a.gpkg"));
  const std::vector<std::string> queries =
      SqlBlocks(std::string(CAIRN_SOURCE_DIR) + "/sql/README.md");
  EXPECT_THAT(queries, SizeIs(12));
  for (const std::string& query : queries) {
    const Result result = Query(path, query);
    EXPECT_THAT(result.rows, SizeIs(Gt(0u))) << query;
    EXPECT_THAT(result.columns, SizeIs(Gt(1u))) << query;
  }
}

TEST(SqlShell, EveryViewCanBeRead) {
  const TempDir dir;
  const std::string path = MakeStreetMap(dir.File("a.gpkg"));
  const Result views =
      Query(path, "SELECT name FROM sqlite_schema WHERE type = 'view' ORDER BY name");
  EXPECT_THAT(views.rows, SizeIs(7));
  for (const auto& row : views.rows) {
    EXPECT_THAT(Query(path, "SELECT * FROM " + row[0].text).rows, SizeIs(Gt(0u))) << row[0].text;
  }
}

TEST(SqlShell, LandmarksAreThoseOfTheTiles) {
  const TempDir dir;
  const std::string path = dir.File("a.gpkg");
  MapStore store = MapStore::Create(path);
  MapUpdate update = store.BeginUpdate();
  update.AddCodebook(testing::RandomCodebook());
  testing::RandomTileOptions options;
  const Tile tile = testing::RandomTile(options);
  options.id = TileId::Containing(Geodetic::FromDegrees(48.0, 8.0, 0.0));
  options.num_landmarks = 0;
  options.num_keyframes = 0;
  const Tile empty = testing::RandomTile(options);
  testing::AddTile(empty, &update);
  testing::AddTile(tile, &update);
  update.Publish();

  const Result all = Query(path, "SELECT *, tile_id FROM cairn_landmarks");
  EXPECT_THAT(all.columns,
              ElementsAre("landmark_id", "tile", "session_id", "x_m", "y_m", "z_m", "lat_deg",
                          "lon_deg", "h_m", "sigma_m", "num_descriptors", "num_keyframes",
                          "last_session_id", "num_sights", "num_chances", "tile_id"));
  ASSERT_THAT(all.rows, SizeIs(100));
  const Rigid3d ecef_from_tile = EcefFromEnu(tile.id.Anchor());
  for (size_t i = 0; i < all.rows.size(); ++i) {
    const std::vector<SqlCell>& row = all.rows[i];
    EXPECT_EQ(row[0].text, std::to_string(Value(tile.landmark_ids[i])));
    EXPECT_EQ(row[1].text, tile.id.ToString());
    EXPECT_EQ(std::stod(row[3].text), tile.x_in_tile[i].x());
    EXPECT_EQ(std::stod(row[5].text), tile.x_in_tile[i].z());
    const Geodetic position = Geodetic::FromDegrees(std::stod(row[6].text), std::stod(row[7].text),
                                                    std::stod(row[8].text));
    EXPECT_LT(
        (EcefFromGeodetic(position) - ecef_from_tile * tile.x_in_tile[i].cast<double>()).norm(),
        1e-3);
    EXPECT_EQ(row[10].text,
              std::to_string(tile.descriptor_begin[i + 1] - tile.descriptor_begin[i]));
    EXPECT_EQ(row[12].text, row[2].text);
    EXPECT_EQ(row[13].text, std::to_string(tile.HistoryOf(i)[0].num_observations));
    EXPECT_EQ(row[14].text, std::to_string(tile.HistoryOf(i)[0].num_chances));
  }
  const std::string id = std::to_string(tile.id.value());
  EXPECT_EQ(Value(path, "SELECT count(*) FROM cairn_landmarks(" + id + ")"), "100");
  EXPECT_EQ(Value(path, "SELECT count(*) FROM cairn_landmarks WHERE tile_id = " + id), "100");
  EXPECT_EQ(Value(path, "SELECT count(*) FROM cairn_landmarks(1)"), "0");
  EXPECT_EQ(Value(path, "SELECT sum(num_keyframes) FROM cairn_landmarks"),
            std::to_string(tile.keyframe_landmarks.size()));
  EXPECT_EQ(Value(path,
                  "SELECT sum(n) FROM v_tiles AS t JOIN "
                  "(SELECT tile_id, count(*) AS n FROM cairn_landmarks GROUP BY tile_id) AS l "
                  "ON l.tile_id = t.tile_id"),
            "100");
}

TEST(SqlShell, TileFunctions) {
  const TempDir dir;
  const std::string path = dir.File("a.gpkg");
  MapStore::Create(path);
  const TileId id = TileId::Containing(Geodetic::FromDegrees(49.011, 8.416, 0.0));
  EXPECT_EQ(Value(path, "SELECT cairn_tile_at(49.011, 8.416)"), std::to_string(id.value()));
  EXPECT_EQ(Value(path, "SELECT cairn_tile_name(cairn_tile_at(49.011, 8.416))"), id.ToString());
  EXPECT_EQ(Value(path, "SELECT cairn_tile_id('" + id.ToString() + "')"),
            std::to_string(id.value()));
  EXPECT_NEAR(std::stod(Value(path, "SELECT cairn_tile_lat(cairn_tile_at(49.011, 8.416))")), 49.011,
              0.001);
  EXPECT_NEAR(std::stod(Value(path, "SELECT cairn_tile_lon(cairn_tile_at(49.011, 8.416))")), 8.416,
              0.0015);
  // A degree along a meridian at the equator.
  EXPECT_NEAR(std::stod(Value(path, "SELECT cairn_distance_m(-0.5, 10, 0.5, 10)")), 110574.4, 1.0);
  EXPECT_TRUE(Query(path, "SELECT cairn_tile_name(NULL)").rows.at(0).at(0).is_null);
  EXPECT_EQ(ErrorCodeOf([&] { Query(path, "SELECT cairn_tile_name(7)"); }), ErrorCode::kBadInput);
  EXPECT_EQ(ErrorCodeOf([&] { Query(path, "SELECT cairn_tile_at(91, 0)"); }), ErrorCode::kBadInput);
  EXPECT_EQ(ErrorCodeOf([&] { Query(path, "SELECT cairn_tile_id('x')"); }), ErrorCode::kBadInput);
}

TEST(SqlShell, CellsSayWhatTheyAre) {
  const TempDir dir;
  MapStore::Create(dir.File("a.gpkg"));
  const Result result =
      Query(dir.File("a.gpkg"), "-- first\nSELECT 1; SELECT 7, 'a', NULL, x'0102', 0.5;\n");
  ASSERT_THAT(result.rows, SizeIs(1));
  const std::vector<SqlCell>& row = result.rows[0];
  EXPECT_EQ(row[0].text, "7");
  EXPECT_TRUE(row[0].is_number);
  EXPECT_EQ(row[1].text, "a");
  EXPECT_FALSE(row[1].is_number);
  EXPECT_TRUE(row[2].is_null);
  EXPECT_EQ(row[3].text, "<2 bytes>");
  EXPECT_EQ(row[4].text, "0.5");
}

TEST(SqlShell, RefusesWhateverWrites) {
  const TempDir dir;
  const std::string path = dir.File("a.gpkg");
  MapStore::Create(path);
  const std::string other = dir.File("other.db");
  const std::vector<std::string> statements = {
      "DELETE FROM cairn_versions",
      "INSERT INTO cairn_versions VALUES (9, '')",
      "CREATE TABLE x (y)",
      "CREATE TEMP TABLE x (y)",
      "DROP VIEW v_map",
      "PRAGMA query_only = OFF",
      "PRAGMA journal_mode = DELETE",
      "PRAGMA wal_checkpoint",
      "PRAGMA user_version = 3",
      "VACUUM",
      "VACUUM INTO '" + other + "'",
      "ATTACH DATABASE '" + other + "' AS x",
      "SELECT load_extension('x')",
  };
  for (const std::string& statement : statements) {
    EXPECT_EQ(ErrorCodeOf([&] { Query(path, statement); }), ErrorCode::kBadInput) << statement;
  }
  EXPECT_FALSE(std::filesystem::exists(other));
  EXPECT_EQ(Value(path, "SELECT version FROM v_map"), "1");
}

TEST(SqlShell, ErrorsCarryTheMessageOfSqlite) {
  const TempDir dir;
  MapStore::Create(dir.File("a.gpkg"));
  try {
    Query(dir.File("a.gpkg"), "SELECT 1; SELEKT 2");
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadInput);
    EXPECT_THAT(error.what(), HasSubstr("near \"SELEKT\": syntax error"));
  }
  EXPECT_EQ(ErrorCodeOf([&] { Query(dir.File("b.gpkg"), "SELECT 1"); }), ErrorCode::kNotFound);
}

TEST(SqlShell, ADamagedTileIsAnError) {
  const TempDir dir;
  const std::string path = dir.File("a.gpkg");
  {
    MapStore store = MapStore::Create(path);
    MapUpdate update = store.BeginUpdate();
    update.AddCodebook(testing::RandomCodebook());
    std::vector<uint8_t> payload = EncodeTile(testing::RandomTile());
    payload[200] ^= 1;
    update.PutTile(testing::RecordOf(testing::RandomTile()), payload);
    update.Publish();
  }
  try {
    Query(path, "SELECT count(*) FROM cairn_landmarks");
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("checksum"));
  }
}

}  // namespace
}  // namespace cairn
