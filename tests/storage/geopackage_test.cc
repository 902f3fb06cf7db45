#include "storage/inspection/geopackage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>

#include "storage/inspection/register.h"
#include "storage/map/sql_shell.h"
#include "support/raw_sql.h"
#include "support/street_map.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;
using testing::MakeStreetMap;
using ::testing::Not;
using testing::TempDir;

struct CommandResult {
  int status = 0;
  std::string output;  // Standard output and error together.
};

CommandResult RunCommand(const std::string& command) {
  CommandResult result;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  std::array<char, 4096> buffer;
  while (const size_t size = fread(buffer.data(), 1, buffer.size(), pipe)) {
    result.output.append(buffer.data(), size);
  }
  result.status = pclose(pipe);
  return result;
}

bool HasProgram(const std::string& name) {
  return std::system(("command -v " + name + " > /dev/null").c_str()) == 0;
}

std::vector<uint8_t> FromHex(const std::string& hex) {
  std::vector<uint8_t> bytes;
  for (size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes.push_back(static_cast<uint8_t>(std::stoi(hex.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

TEST(GeoPackage, OgrinfoOpensAMapWithoutAWarning) {
  if (!HasProgram("ogrinfo")) {
    GTEST_SKIP() << "ogrinfo not found (apt-get install gdal-bin)";
  }
  const TempDir dir;
  const std::string path = MakeStreetMap(dir.File("a.gpkg"));
  const CommandResult result = RunCommand("ogrinfo -al '" + path + "'");
  EXPECT_EQ(result.status, 0);
  EXPECT_THAT(result.output, Not(HasSubstr("Warning")));
  EXPECT_THAT(result.output, Not(HasSubstr("ERROR")));
  EXPECT_THAT(result.output, HasSubstr("Layer name: coverage"));
  EXPECT_THAT(result.output, HasSubstr("Layer name: keyframes"));
  EXPECT_THAT(result.output, HasSubstr("POINT Z (8.416"));
  EXPECT_THAT(result.output, HasSubstr("POLYGON ((8.41"));
  EXPECT_THAT(result.output, Not(HasSubstr("Layer name: cairn_payloads")));
}

// GDAL's validator goes through the requirements of the standard.
constexpr const char* kValidator = "/usr/bin/python3 -m osgeo_utils.samples.validate_gpkg";

bool HasValidator() {
  return std::system(
             "/usr/bin/python3 -c 'import osgeo_utils.samples.validate_gpkg' 2> /dev/null") == 0;
}

TEST(GeoPackage, NewMapsAndFilledOnesAreValid) {
  if (!HasValidator()) {
    GTEST_SKIP() << "validate_gpkg not found (apt-get install python3-gdal)";
  }
  const TempDir dir;
  const std::string filled = MakeStreetMap(dir.File("filled.gpkg"));
  const std::string empty = dir.File("empty.gpkg");
  MapStore::Create(empty);
  for (const std::string& path : {empty, filled}) {
    const CommandResult result =
        RunCommand(std::string(kValidator) + " -k --extra --warning-as-error '" + path + "'");
    EXPECT_EQ(result.status, 0) << path << ": " << result.output;
    EXPECT_EQ(result.output, "") << path;
  }
}

TEST(GeoPackage, TheValidatorFindsWhatIsWrong) {
  if (!HasValidator()) {
    GTEST_SKIP() << "validate_gpkg not found (apt-get install python3-gdal)";
  }
  const TempDir dir;
  const std::string path = MakeStreetMap(dir.File("a.gpkg"));
  testing::ExecuteRaw(path, "DELETE FROM gpkg_spatial_ref_sys WHERE srs_id = 4326");
  EXPECT_NE(RunCommand(std::string(kValidator) + " -k '" + path + "'").status, 0);
}

// What QGIS does when it saves a style into the map, by the same library.
TEST(GeoPackage, MapsStayMapsWhenGdalAddsATable) {
  if (!HasValidator()) {
    GTEST_SKIP() << "no GDAL for Python (apt-get install python3-gdal)";
  }
  const TempDir dir;
  const std::string path = MakeStreetMap(dir.File("a.gpkg"));
  const CommandResult result = RunCommand(
      "/usr/bin/python3 -c \"from osgeo import gdal, ogr; gdal.UseExceptions(); "
      "map = gdal.OpenEx('" +
      path +
      "', gdal.OF_UPDATE | gdal.OF_VECTOR); "
      "map.SetMetadataItem('author', 'somebody'); "
      "styles = map.CreateLayer('layer_styles', geom_type=ogr.wkbNone); "
      "styles.CreateField(ogr.FieldDefn('styleQML', ogr.OFTString)); "
      "row = ogr.Feature(styles.GetLayerDefn()); row['styleQML'] = '<qgis/>'; "
      "styles.CreateFeature(row); map = None\"");
  ASSERT_EQ(result.status, 0) << result.output;
  EXPECT_THAT(MapStore::Open(path, OpenMode::kReadWrite).Check({}).problems, ::testing::IsEmpty());
}

TEST(GeoPackage, EveryUpdateIsTheLastChangeOfEveryLayer) {
  const TempDir dir;
  const std::string path = MakeStreetMap(dir.File("a.gpkg"));
  testing::ExecuteRaw(path, "UPDATE gpkg_contents SET last_change = '2000-01-01T00:00:00.000Z'");
  MapStore::Open(path, OpenMode::kReadWrite).BeginUpdate().Publish();
  std::vector<std::string> left_behind;
  SqlSink sink;
  sink.on_columns = [](const std::vector<std::string>&) {};
  sink.on_row = [&](const std::vector<SqlCell>& row) { left_behind.push_back(row.at(0).text); };
  RunSql(path, "SELECT table_name FROM gpkg_contents WHERE last_change < '2001'", {}, sink);
  EXPECT_THAT(left_behind, ::testing::IsEmpty());
}

TEST(GeoPackage, OgrFindsFeaturesThroughTheIndex) {
  if (!HasProgram("ogrinfo")) {
    GTEST_SKIP() << "ogrinfo not found (apt-get install gdal-bin)";
  }
  const TempDir dir;
  const std::string path = MakeStreetMap(dir.File("a.gpkg"));
  const CommandResult result =
      RunCommand("ogrinfo -so -spat 8.4159 49.0109 8.4161 49.0111 '" + path + "' keyframes");
  EXPECT_THAT(result.output, HasSubstr("Feature Count: 5"));
}

TEST(GeoPackage, EnvelopesOfWhatWeWrite) {
  const auto point = EnvelopeOfGeometry(PointGeometry(Geodetic::FromDegrees(49.0, 8.5, 100.0)));
  ASSERT_TRUE(point.has_value());
  EXPECT_DOUBLE_EQ(point->min_x, 8.5);
  EXPECT_DOUBLE_EQ(point->max_y, 49.0);
  const TileId id = TileId::Containing(Geodetic::FromDegrees(49.0, 8.5, 0.0));
  const auto square = EnvelopeOfGeometry(TileGeometry(id));
  ASSERT_TRUE(square.has_value());
  EXPECT_NEAR(square->min_y, Geodetic({id.Bounds().south_rad, 0, 0}).lat_deg(), 1e-9);
  EXPECT_NEAR(square->max_x, Geodetic({0, id.Bounds().east_rad, 0}).lon_deg(), 1e-9);
  EXPECT_LT(square->max_x - square->min_x, 0.003);
}

TEST(GeoPackage, ASquareOnTheAntimeridianStaysSmall) {
  const TileId id = TileId::Containing(Geodetic::FromDegrees(-17.0, 179.99999, 0.0));
  const auto square = EnvelopeOfGeometry(TileGeometry(id));
  ASSERT_TRUE(square.has_value());
  EXPECT_LT(square->max_x - square->min_x, 0.003);
}

TEST(GeoPackage, EnvelopesOfForeignGeometries) {
  // A big-endian header without envelope around a big-endian line string (1 2, 5 -3).
  const auto line =
      EnvelopeOfGeometry(FromHex("47500000000010E6"
                                 "000000000200000002"
                                 "3FF0000000000000"
                                 "4000000000000000"
                                 "4014000000000000"
                                 "C008000000000000"));
  ASSERT_TRUE(line.has_value());
  EXPECT_EQ(line->min_x, 1.0);
  EXPECT_EQ(line->max_x, 5.0);
  EXPECT_EQ(line->min_y, -3.0);
  EXPECT_EQ(line->max_y, 2.0);
  // An empty point is written with NaN, and flagged.
  const auto empty =
      EnvelopeOfGeometry(FromHex("47500011E6100000"
                                 "0101000000000000000000F87F000000000000F87F"));
  ASSERT_TRUE(empty.has_value());
  EXPECT_TRUE(empty->is_empty);
}

TEST(GeoPackage, HostileGeometriesAreRefusedOrRead) {
  EXPECT_FALSE(EnvelopeOfGeometry({}).has_value());
  const std::vector<uint8_t> square =
      TileGeometry(TileId::Containing(Geodetic::FromDegrees(49.0, 8.5, 0.0)));
  std::vector<uint8_t> bare = square;  // The same without an envelope in the header.
  bare[3] = 1;
  bare.erase(bare.begin() + 8, bare.begin() + 40);
  ASSERT_TRUE(EnvelopeOfGeometry(bare).has_value());
  for (size_t size = 0; size < bare.size(); ++size) {
    EXPECT_FALSE(EnvelopeOfGeometry({bare.data(), size}).has_value()) << size;
  }
  for (size_t bit = 0; bit < 8 * bare.size(); ++bit) {
    std::vector<uint8_t> flipped = bare;
    flipped[bit / 8] ^= 1 << bit % 8;
    EnvelopeOfGeometry(flipped);
  }
  // Collections in collections without end.
  std::vector<uint8_t> nested = FromHex("47500001E6100000");
  for (int i = 0; i < 100'000; ++i) {
    const std::vector<uint8_t> level = FromHex("010700000001000000");
    nested.insert(nested.end(), level.begin(), level.end());
  }
  EXPECT_FALSE(EnvelopeOfGeometry(nested).has_value());
}

TEST(GeoPackage, TriggersKeepTheIndexUpToDate) {
  const TempDir dir;
  const std::string path = MakeStreetMap(dir.File("a.gpkg"));
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &db), SQLITE_OK);
  ASSERT_EQ(inspection::RegisterInspection(db), SQLITE_OK);
  const auto number = [db](const std::string& sql) {
    sqlite3_stmt* statement = nullptr;
    EXPECT_EQ(sqlite3_prepare_v2(db, sql.c_str(), -1, &statement, nullptr), SQLITE_OK)
        << sqlite3_errmsg(db);
    const int result = sqlite3_step(statement);
    EXPECT_TRUE(result == SQLITE_ROW || result == SQLITE_DONE) << sqlite3_errmsg(db);
    const double value = result == SQLITE_ROW ? sqlite3_column_double(statement, 0) : NAN;
    sqlite3_finalize(statement);
    return value;
  };
  number(
      "UPDATE keyframes SET geom = (SELECT geom FROM keyframes WHERE keyframe_id = 15) "
      "WHERE keyframe_id = 1");
  EXPECT_NEAR(number("SELECT minx FROM rtree_keyframes_geom WHERE id = 1"), 8.4202, 1e-4);
  number(
      "UPDATE keyframes SET geom = x'47500011E61000000101000000000000000000F87F000000000000F87F' "
      "WHERE keyframe_id = 1");
  EXPECT_EQ(number("SELECT count(*) FROM rtree_keyframes_geom WHERE id = 1"), 0);
  number("UPDATE keyframes SET keyframe_id = 99 WHERE keyframe_id = 2");
  EXPECT_EQ(number("SELECT count(*) FROM rtree_keyframes_geom WHERE id = 99"), 1);
  EXPECT_EQ(number("SELECT count(*) FROM rtree_keyframes_geom WHERE id = 2"), 0);
  number("DELETE FROM keyframes");
  EXPECT_EQ(number("SELECT count(*) FROM rtree_keyframes_geom"), 0);
  sqlite3_close(db);
}

TEST(SqliteExtension, WorksInTheShell) {
  if (std::string(CAIRN_SANITIZER) != "") {
    GTEST_SKIP() << "the shell cannot load an extension built with -fsanitize=" CAIRN_SANITIZER;
  }
  if (!HasProgram("sqlite3")) {
    GTEST_SKIP() << "sqlite3 not found (apt-get install sqlite3)";
  }
  const TempDir dir;
  const std::string path = MakeStreetMap(dir.File("a.gpkg"));
  const std::string shell = "sqlite3 -cmd '.load " CAIRN_SQLITE_EXTENSION_PATH "' '" + path + "' ";
  EXPECT_EQ(RunCommand(shell + "'SELECT count(*) FROM cairn_landmarks'").output, "150\n");
  EXPECT_EQ(RunCommand(shell + "'SELECT cairn_tile_name(cairn_tile_at(49.011, 8.416))'").output,
            TileId::Containing(Geodetic::FromDegrees(49.011, 8.416, 0.0)).ToString() + "\n");
  EXPECT_EQ(RunCommand(shell + "'DELETE FROM keyframes; SELECT count(*) FROM rtree_keyframes_geom'")
                .output,
            "0\n");
}

}  // namespace
}  // namespace cairn
