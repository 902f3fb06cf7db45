// `cairn map` of several folders: each becomes a session of one map.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "cli/map_session.h"
#include "core/error.h"
#include "core/geodesy.h"
#include "mapping/photo_scene.h"
#include "support/expect_error.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;
using testing::PhotoScene;
using testing::Shot;
using ::testing::StartsWith;

class MapFolders : public ::testing::Test {
 protected:
  MapFolders() {
    testing::WriteFolder(PhotoScene(7), testing::Walk(11), dir_.path() / "tuesday");
    std::vector<Shot> monday = testing::Walk(9, 1.0);
    for (Shot& shot : monday) {
      shot.x_in_enu += Eigen::Vector3d(0.0, 0.4, 0.1);
      shot.yaw_rad *= -0.5;
      shot.gps_error_m += Eigen::Vector3d(1.5, -1.0, 0.5);  // One bias for all.
    }
    testing::WriteFolder(PhotoScene(7), monday, dir_.path() / "monday");
  }

  MapSessionArguments Arguments(const std::vector<std::string>& folders) const {
    MapSessionArguments arguments;
    arguments.session.map_path = dir_.File("town.gpkg");
    arguments.session.options.mapping.sift.max_features = 1000;
    arguments.session.options.ingest.num_threads = 2;
    arguments.session.options.ingest.recorded_at = "2026-01-31T12:00:00Z";
    for (const std::string& folder : folders) {
      arguments.input.paths.push_back(dir_.File(folder));
    }
    arguments.input.work_dir = dir_.File("w");
    return arguments;
  }

  std::vector<MapSessionResult> Map(const std::vector<std::string>& folders) const {
    return MakeMapSessions(Arguments(folders), {});
  }

  std::string ReadAll(const std::string& name) const {
    std::ifstream file(dir_.File(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  testing::TempDir dir_;
};

TEST_F(MapFolders, WithoutAModelKeepNoOtherOut) {
  std::vector<Shot> blurred = testing::Walk(4);
  for (Shot& shot : blurred) {
    shot.blur_px = 40.0;
  }
  testing::WriteFolder(PhotoScene(7), blurred, dir_.path() / "blurred");
  const std::vector<MapSessionResult> sessions = Map({"blurred", "tuesday"});
  ASSERT_EQ(sessions.size(), 2u);
  EXPECT_TRUE(sessions[0].is_in_map);
  EXPECT_EQ(sessions[1].name, "blurred");
  EXPECT_FALSE(sessions[1].is_mapped);
  EXPECT_THAT(sessions[1].problem, HasSubstr("none of the 4 photos can be read"));
  const std::string svg = ReadAll("w/report.svg");
  EXPECT_THAT(svg, StartsWith("<svg"));
  EXPECT_THAT(svg, HasSubstr(">tuesday</text>"));
  EXPECT_THAT(svg, HasSubstr(">blurred</text>"));
  EXPECT_THAT(svg, HasSubstr("2 sessions, 1 of them without a model"));
  EXPECT_THAT(ReadAll("w/report.png"), StartsWith("\x89PNG"));
}

TEST_F(MapFolders, LeaveNothingInTheArchiveOfAMapThatIsNotMade) {
  MapSessionArguments arguments = Arguments({"tuesday"});
  arguments.archive_path = dir_.File("archive");
  std::filesystem::create_directory(arguments.archive_path);
  const auto take_name = [&](const char* phase, int64_t, int64_t) {
    if (std::string(phase) == "tiles") {
      std::ofstream(arguments.session.map_path) << "of another program";
    }
  };
  testing::ExpectError([&] { MakeMapSessions(arguments, take_name); }, ErrorCode::kConflict,
                       "already exists");
  EXPECT_TRUE(std::filesystem::is_empty(arguments.archive_path));
}

TEST_F(MapFolders, WithExchangedLatitudeAndLongitudeAreRefusedWithAPicture) {
  Map({"tuesday"});
  std::vector<Shot> exchanged = testing::Walk(9, 1.0);
  for (Shot& shot : exchanged) {
    const Geodetic gps =
        GeodeticFromEcef(EcefFromEnu(PhotoScene::Origin()) * (shot.x_in_enu + shot.gps_error_m));
    shot.exif.lat_deg = gps.lon_deg();
    shot.exif.lon_deg = gps.lat_deg();
    shot.exif.altitude_m = gps.h_m;
  }
  testing::WriteFolder(PhotoScene(7), exchanged, dir_.path() / "exchanged");
  std::filesystem::remove_all(dir_.File("w"));
  testing::ExpectError([&] { Map({"exchanged"}); }, ErrorCode::kBadInput,
                       "have probably changed places");
  EXPECT_THAT(ReadAll("w/report.svg"), HasSubstr(">exchanged</text>"));
}

TEST_F(MapFolders, OfOneNameAreRefused) {
  std::filesystem::create_directories(dir_.path() / "more/monday");
  testing::ExpectError(
      [&] {
        Map({"monday", "more/monday"});
      },
      ErrorCode::kInvalidArgument, "two folders have the name monday");
}

TEST_F(MapFolders, AreOneSessionUnderAName) {
  MapSessionArguments arguments = Arguments({"monday", "tuesday"});
  arguments.session.options.ingest.session_name = "week";
  const std::vector<MapSessionResult> sessions = MakeMapSessions(arguments, {});
  ASSERT_EQ(sessions.size(), 1u);
  EXPECT_EQ(sessions[0].name, "week");
  EXPECT_EQ(sessions[0].mapped.num_photos, 20);
}

}  // namespace
}  // namespace cairn
