// Tests the findings of MapStore::Check, one test per fault.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "storage/map/map_store.h"
#include "support/map_builder.h"
#include "support/map_place.h"
#include "support/raw_sql.h"
#include "support/street_map.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::Contains;
using testing::ExecuteRaw;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;

// A street map of three tiles with fifteen keyframes.
class MapCheck : public testing::MapPlaceTest {
 protected:
  void SetUp() override {
    testing::MapPlaceTest::SetUp();
    if (!IsSkipped()) {
      path_ = testing::MakeStreetMap(Place("a"));
    }
  }

  std::vector<std::string> Problems() const {
    return MapStore::Open(path_, OpenMode::kReadOnly).Check({}).problems;
  }

  // Runs the statements, which damage the map, and expects the problem to be found.
  void ExpectFound(const std::string& sql, const std::string& problem) const {
    ExecuteRaw(path_, sql);
    EXPECT_THAT(Problems(), Contains(HasSubstr(problem)));
  }

  bool IsFile() const { return GetParam() == testing::MapKind::kFile; }
  // A byte of 0, and infinities, in the SQL of the map's database.
  std::string ZeroByte() const { return IsFile() ? "x'00'" : "'\\x00'::bytea"; }
  std::string Infinity() const { return IsFile() ? "9e999" : "'Infinity'"; }
  std::string MinusInfinity() const { return IsFile() ? "-9e999" : "'-Infinity'"; }

  std::string path_;
};

CAIRN_ON_BOTH_KINDS_OF_MAPS(MapCheck);

TEST_P(MapCheck, ASoundMapHasNoProblems) { EXPECT_THAT(Problems(), IsEmpty()); }

TEST_P(MapCheck, ADamagedCodebook) {
  ExpectFound("UPDATE cairn_codebooks SET bytes = " + ZeroByte(), "codebook 1: ");
}

TEST_P(MapCheck, ADamagedNewestCodebookThatNoTileUses) {
  ExpectFound(
      "INSERT INTO cairn_codebooks (codebook_id, created_at, digest, bytes) "
      "VALUES (2, 'now', '00000000000000000000000000000002', " +
          ZeroByte() + ")",
      "codebook 2: ");
}

TEST_P(MapCheck, TilesOfACodebookThatIsNotTheVersions) {
  ExpectFound(
      "INSERT INTO cairn_codebooks (codebook_id, created_at, digest, bytes) "
      "SELECT 2, created_at, '00000000000000000000000000000002', bytes FROM cairn_codebooks;"
      "UPDATE cairn_map SET codebook_id = 2;"
      "UPDATE cairn_versions SET codebook_id = 2 WHERE version = 2",
      "it is not coded with its version's codebook");
  EXPECT_THAT(Problems(), Contains("codebook 2: does not match its digest"));
}

TEST_P(MapCheck, ACodebookThatIsNotTheLatestVersions) {
  ExpectFound("UPDATE cairn_map SET codebook_id = NULL",
              "its codebook is not the codebook of the latest version");
}

TEST_P(MapCheck, ADigestThatIsNotThePayloads) {
  ExpectFound("UPDATE cairn_payloads SET digest = '0000000000000000000000000000000' || payload_id",
              "its payload does not match its digest");
}

TEST_P(MapCheck, TotalsAndBoundsThatAreNotTheVersions) {
  ExpectFound("UPDATE cairn_versions SET num_landmarks = num_landmarks + 1 WHERE version = 2",
              "1 versions have totals that do not match their content");
  ExpectFound("UPDATE cairn_versions SET north_deg = north_deg + 1 WHERE version = 2",
              "the bounds of the latest version do not match its tiles");
  ExpectFound("UPDATE cairn_versions SET south_deg = 1 WHERE version = 1",
              "1 versions have invalid bounds");
}

TEST_P(MapCheck, VersionsThatAreMissing) {
  ExpectFound("UPDATE cairn_versions SET version = 4 WHERE version = 2", "versions are missing");
}

TEST_P(MapCheck, RowsOfVersionsThatTheMapNeverHad) {
  ExpectFound("UPDATE cairn_tiles SET since = 9",
              "3 rows are from versions that the map never had");
}

// One tile of the past, which version 2 had.
class MapCheckOfThePast : public MapCheck {
 protected:
  void SetUp() override {
    MapCheck::SetUp();
    if (IsSkipped()) {
      return;
    }
    MapStore store = MapStore::Open(path_, OpenMode::kReadWrite);
    MapUpdate update = store.BeginUpdate();
    update.RemoveTile(store.Snapshot().AllTiles(1)[0].tile_id);
    update.RemoveKeyframe(KeyframeId(1));
    update.Publish();
  }
};

CAIRN_ON_BOTH_KINDS_OF_MAPS(MapCheckOfThePast);

TEST_P(MapCheckOfThePast, ASoundMapHasNoProblems) {
  const CheckReport report = MapStore::Open(path_, OpenMode::kReadOnly).Check({});
  EXPECT_THAT(report.problems, IsEmpty());
  EXPECT_EQ(report.num_tiles_checked, 3);
}

TEST_P(MapCheckOfThePast, ADamagedPayload) {
  ExpectFound("UPDATE cairn_payloads SET bytes = " + ZeroByte() +
                  " WHERE payload_id = (SELECT payload_id FROM cairn_past_tiles)",
              "as of version 2: ");
}

TEST_P(MapCheckOfThePast, ATileThatIsThereTwice) {
  ExpectFound("UPDATE cairn_past_tiles SET tile_id = (SELECT min(tile_id) FROM cairn_tiles)",
              "1 tiles are in the map and in its past in one version");
}

TEST_P(MapCheckOfThePast, AKeyframeWithoutACameraOrAPose) {
  ExpectFound("UPDATE cairn_past_keyframes SET camera_id = 77",
              "1 keyframes of the past have no camera");
  ExpectFound("UPDATE cairn_past_keyframes SET camera_id = 1, qw = 0, qx = 0, qy = 0, qz = 0",
              "a keyframe of the past: ");
}

TEST_P(MapCheckOfThePast, RowsOfVersionsThatAreNotKept) {
  ExpectFound("UPDATE cairn_past_tiles SET until = 77",
              "1 rows of the past belong to versions that");
}

TEST_P(MapCheckOfThePast, AKeyframeThatIsThereTwice) {
  ExpectFound(
      "UPDATE cairn_past_keyframes SET since = 1, until = 3;"
      "INSERT INTO cairn_past_keyframes SELECT keyframe_id, 2, 3, session_id, tile_id, image_name, "
      "camera_id, qw, qx, qy, qz, tx_m, ty_m, tz_m FROM cairn_past_keyframes",
      "1 keyframes of the past appear twice in one version");
}

TEST_P(MapCheckOfThePast, ASessionThatIsThereTwice) {
  const auto insert = [](const std::string& since) {
    return "INSERT INTO cairn_past_sessions SELECT 77, " + since +
           ", 3, name, source, created_at, recorded_at, content_digest, num_images, num_landmarks, "
           "georef_median_residual_m FROM cairn_sessions WHERE session_id = 1;";
  };
  ExpectFound(insert("1") + insert("2"), "1 sessions of the past appear twice in one version");
}

TEST_P(MapCheck, AMissingCodebook) {
  ExpectFound("DELETE FROM cairn_codebooks", "has no codebook 1");
  if (IsFile()) {
    EXPECT_THAT(Problems(), Contains(HasSubstr("refer to missing rows")));
  }
}

TEST_P(MapCheck, AMissingPayload) {
  ExpectFound("DELETE FROM cairn_payloads WHERE payload_id = 2", "has no payload 2");
}

TEST_P(MapCheck, AMovedGeometry) {
  ExpectFound(
      "UPDATE keyframes SET geom = (SELECT geom FROM keyframes WHERE keyframe_id = 15) "
      "WHERE keyframe_id = 1",
      "keyframe 1: its geometry is in the wrong place");
}

// Refused by queries, too, which would look for cameras there.
TEST_P(MapCheck, ImpossibleHeights) {
  for (const std::string& heights :
       {std::string("min_h_m = -9e9"), "max_h_m = " + Infinity(), "min_h_m = " + MinusInfinity(),
        std::string("min_h_m = 300, max_h_m = 200")}) {
    ExecuteRaw(path_, "UPDATE coverage SET min_h_m = 115, max_h_m = 115");
    ExpectFound("UPDATE coverage SET " + heights, "its cameras have heights of");
    const MapSnapshot snapshot = MapStore::Open(path_, OpenMode::kReadOnly).Snapshot();
    EXPECT_EQ(testing::ErrorCodeOf([&] { snapshot.AllTiles(10); }), ErrorCode::kMapDamaged);
  }
}

TEST_P(MapCheck, HeightsThatAreNotThoseOfTheKeyframes) {
  ExpectFound("UPDATE coverage SET max_h_m = 200", "its heights do not match its keyframes");
}

TEST_P(MapCheck, ARotationOfZero) {
  ExpectFound(
      "UPDATE cairn_keyframe_poses SET qw = 0, qx = 0, qy = 0, qz = 0 WHERE keyframe_id = 4",
      "keyframe 4: ");
}

TEST_P(MapCheck, ARotationThatIsNone) {
  ExpectFound("UPDATE cairn_keyframe_poses SET qw = 3 WHERE keyframe_id = 4", "keyframe 4: ");
}

TEST_P(MapCheck, AnInfiniteRotation) {
  ExpectFound("UPDATE cairn_keyframe_poses SET qx = " + Infinity() + " WHERE keyframe_id = 4",
              "keyframe 4: ");
}

TEST_P(MapCheck, AnInfiniteTranslation) {
  ExpectFound(
      "UPDATE cairn_keyframe_poses SET tx_m = " + MinusInfinity() + " WHERE keyframe_id = 5",
      "keyframe 5: ");
}

TEST_P(MapCheck, AKeyframeInTheMiddleOfTheEarth) {
  ExpectFound("UPDATE cairn_keyframe_poses SET tx_m = 0, ty_m = 0, tz_m = 0 WHERE keyframe_id = 5",
              "keyframe 5: its pose: height");
}

TEST_P(MapCheck, AMovedPose) {
  ExpectFound("UPDATE cairn_keyframe_poses SET tz_m = tz_m + 1 WHERE keyframe_id = 5",
              "keyframe 5: its latitude, longitude and height do not match its pose");
  EXPECT_THAT(Problems(), Contains(HasSubstr("has a different pose in the map")));
}

TEST_P(MapCheck, AnUnknownCameraModel) {
  ExpectFound("UPDATE cairn_cameras SET model = 'MAGIC'", "camera model 'MAGIC' is not supported");
}

TEST_P(MapCheck, CameraParametersThatAreNone) {
  ExpectFound("UPDATE cairn_cameras SET params = '[1,2'", "are not a list of numbers");
}

TEST_P(MapCheck, AWrongTileOfAKeyframe) {
  ExpectFound(
      "UPDATE keyframes SET tile_id = (SELECT max(tile_id) FROM coverage) "
      "WHERE keyframe_id = 1",
      "keyframe 1: it stands outside its tile");
}

TEST_P(MapCheck, ATileIdThatIsNone) {
  ExpectFound("UPDATE keyframes SET tile_id = -1 WHERE keyframe_id = 1", "keyframe 1: ");
}

TEST_P(MapCheck, AWrongHeading) {
  ExpectFound("UPDATE keyframes SET heading_deg = 90 WHERE keyframe_id = 2",
              "keyframe 2: its heading does not match its pose");
}

TEST_P(MapCheck, BoundsThatDoNotHoldTheLandmarks) {
  ExpectFound("UPDATE cairn_tiles SET landmarks_north_deg = landmarks_south_deg",
              "its landmark bounds do not match its landmarks");
}

TEST_P(MapCheck, AWrongNameOfATile) {
  ExpectFound(
      "UPDATE coverage SET tile = '01N-00001-00001' "
      "WHERE tile_id = (SELECT min(tile_id) FROM coverage)",
      "its name does not match its id");
}

TEST_P(MapCheck, AWrongSizeOfAPayload) {
  ExpectFound("UPDATE coverage SET num_bytes = 1",
              "its payload does not have the size that the tables give");
  if (IsFile()) {
    EXPECT_THAT(Problems(), Contains(HasSubstr("3 tiles have a payload size that differs")));
  }
}

TEST_P(MapCheck, LandmarkIdsThatWouldBeGivenAgain) {
  ExpectFound("UPDATE cairn_map SET next_landmark_id = 10",
              "landmark ids that the map has not reserved");
}

TEST_P(MapCheck, CountersThatCannotGoOn) {
  ExpectFound("UPDATE cairn_map SET next_landmark_id = 9223372036854775807",
              "the next landmark id is too large");
  ExpectFound("UPDATE cairn_versions SET version = 9223372036854775807 WHERE version = 2",
              "no version, or a version that is too large");
  if (IsFile()) {
    ExpectFound("UPDATE sqlite_sequence SET seq = 9223372036854775807", "id sequences");
  }
}

TEST_P(MapCheck, LandmarksOfAnUnknownSession) {
  ExpectFound("UPDATE cairn_sessions SET session_id = 9 WHERE session_id = 2",
              "landmarks of sessions that are not in the map");
}

TEST_P(MapCheck, TimesAndDigestsOfSessionsThatAreNone) {
  ExpectFound(
      "UPDATE cairn_sessions SET recorded_at = 'in May' WHERE session_id = 1;"
      "UPDATE cairn_sessions SET content_digest = 'xyz' WHERE session_id = 2",
      "2 sessions have invalid times or digests");
}

TEST_P(MapCheck, KeyframesOfAPayloadThatTheMapLacks) {
  ExpectFound(
      "DELETE FROM cairn_keyframe_poses WHERE keyframe_id = 1;"
      "DELETE FROM keyframes WHERE keyframe_id = 1",
      "a keyframe of its payload is not in the map");
}

TEST_P(MapCheck, ReportsOfManyEqualProblemsStayShort) {
  ExecuteRaw(path_, "UPDATE cairn_keyframe_poses SET qw = 0, qx = 0, qy = 0, qz = 0");
  EXPECT_LT(Problems().size(), 30u);
}

// The work of a check in proportion to the map: ten times the keyframes take ten times the steps.
// Broken off by Connection's limit of steps a byte if it were not so.
TEST_P(MapCheck, AMapOfManyKeyframesIsCheckedToTheEnd) {
  MapStore store = MapStore::Open(path_, OpenMode::kReadWrite);
  MapUpdate update = store.BeginUpdate();
  const KeyframeRecord keyframe =
      testing::KeyframeAt(Geodetic::FromDegrees(49.011, 8.416, 115.0), SessionId(1));
  for (int i = 0; i < 5000; ++i) {
    update.AddKeyframe(keyframe);
  }
  update.Publish();
  EXPECT_THAT(Problems(), IsEmpty());
}

// What only files have: R*Trees, the tables of GeoPackage, columns of any type.
class MapCheckOfAFile : public ::testing::Test {
 protected:
  std::vector<std::string> Problems() const {
    return MapStore::Open(path_, OpenMode::kReadOnly).Check({}).problems;
  }

  void ExpectFound(const std::string& sql, const std::string& problem) const {
    ExecuteRaw(path_, sql);
    EXPECT_THAT(Problems(), Contains(HasSubstr(problem)));
  }

  testing::TempDir dir_;
  std::string path_ = testing::MakeStreetMap(dir_.File("a.gpkg"));
};

TEST_F(MapCheckOfAFile, AMovedBoxInTheTileIndex) {
  ExpectFound(
      "UPDATE rtree_coverage_geom SET minx = minx + 1, maxx = maxx + 1 WHERE id = "
      "(SELECT min(tile_id) FROM coverage)",
      "its box in the spatial index does not match it");
}

TEST_F(MapCheckOfAFile, AShrunkBoxInTheTileIndex) {
  ExpectFound("UPDATE rtree_coverage_geom SET maxy = miny", "its box in the spatial index");
}

TEST_F(MapCheckOfAFile, AMovedBoxInTheKeyframeIndex) {
  ExpectFound("UPDATE rtree_keyframes_geom SET miny = miny - 1, maxy = maxy - 1 WHERE id = 3",
              "keyframe 3: its box in the spatial index does not match it");
}

TEST_F(MapCheckOfAFile, ABoxOfNoTile) {
  ExpectFound("INSERT INTO rtree_coverage_geom VALUES (77, 8, 9, 49, 50)",
              "1 boxes of the spatial index belong to no tile");
}

TEST_F(MapCheckOfAFile, AGeometryThatIsNone) {
  ExpectFound("UPDATE keyframes SET geom = zeroblob(3) WHERE keyframe_id = 1",
              "keyframe 1: its geometry is in the wrong place");
}

TEST_F(MapCheckOfAFile, LayersThatGeoPackageReadersDoNotFind) {
  ExpectFound(
      "DELETE FROM gpkg_geometry_columns WHERE table_name = 'coverage';"
      "DELETE FROM gpkg_extensions WHERE table_name = 'coverage';"
      "DELETE FROM gpkg_contents WHERE table_name = 'coverage';",
      "1 layers are missing in gpkg_contents");
  EXPECT_THAT(Problems(),
              IsSupersetOf({HasSubstr("gpkg_geometry_columns"), HasSubstr("gpkg_extensions")}));
}

TEST_F(MapCheckOfAFile, AnExtentThatIsNotTheLayers) {
  ExpectFound("UPDATE gpkg_contents SET min_x = 100 WHERE table_name = 'coverage'",
              "a wrong extent in gpkg_contents");
}

TEST_F(MapCheckOfAFile, AnExtentThatIsNotTheKeyframes) {
  ExpectFound("UPDATE gpkg_contents SET max_y = NULL WHERE table_name = 'keyframes'",
              "1 layers have a wrong extent in gpkg_contents");
}

TEST_F(MapCheckOfAFile, TypesOfColumnsThatAreWrong) {
  ExpectFound("UPDATE keyframes SET lat_deg = 'north' WHERE keyframe_id = 7", "keyframe 7: ");
}

}  // namespace
}  // namespace cairn
