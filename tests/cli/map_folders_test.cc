// `cairn map` of several folders: each becomes a session of one map.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/map_session.h"
#include "cli/map_summary.h"
#include "core/error.h"
#include "core/geodesy.h"
#include "mapping/photo_scene.h"
#include "storage/map/map_store.h"
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

  // Where the photos of a map stand, ECEF.
  std::map<std::string, Eigen::Vector3d> CentersIn(const std::string& map_name) const {
    const MapStore map = MapStore::Open(dir_.File(map_name), OpenMode::kReadOnly);
    std::map<std::string, Eigen::Vector3d> centers;
    for (const SessionRecord& session : map.Snapshot().Sessions()) {
      for (const KeyframeRecord& keyframe : map.Snapshot().KeyframesOfSession(session.id)) {
        centers[session.name + "/" + keyframe.image_name] =
            keyframe.cam_from_ecef.Inverse().translation;
      }
    }
    return centers;
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

TEST_F(MapFolders, BecomeSessionsOfOneMapInAnyOrder) {
  const std::vector<MapSessionResult> sessions = Map({"monday", "tuesday"});
  ASSERT_EQ(sessions.size(), 2u);
  EXPECT_TRUE(sessions[0].is_in_map);
  ASSERT_TRUE(sessions[1].is_in_map) << sessions[1].problem;
  EXPECT_TRUE(IsAnchored(sessions[1].report.comparison.anchoring));
  EXPECT_LT(sessions[1].report.comparison.fit.median_residual_m, 0.05);

  MapSessionArguments turned = Arguments({"tuesday", "monday"});
  turned.session.map_path = dir_.File("turned.gpkg");
  turned.session.options.ingest.num_threads = 1;
  MakeMapSessions(turned, {});
  const auto centers = CentersIn("town.gpkg");
  EXPECT_EQ(centers.size(), 20u);
  EXPECT_EQ(centers, CentersIn("turned.gpkg"));
}

TEST_F(MapFolders, SayWhatBecameOfTheirPhotos) {
  const nlohmann::ordered_json json = MapSessionsJson(Map({"monday", "tuesday"}));
  ASSERT_EQ(json["sessions"].size(), 2u);
  const nlohmann::ordered_json& first = json["sessions"][0]["photos"];
  const nlohmann::ordered_json& second = json["sessions"][1]["photos"];
  EXPECT_EQ(first["found"], 11);
  EXPECT_EQ(first["mapped"], 11);
  EXPECT_EQ(first["leftOut"].size(), 0u);
  EXPECT_EQ(first["scale"], "positions");
  EXPECT_EQ(second["scale"], "map");
  EXPECT_NEAR(first["cameras"][0]["params"][0].get<double>(), 284.0, 3.0);
  EXPECT_EQ(first["cameras"][0]["focalSource"], "EXIF");
  EXPECT_EQ(first["stages"].front()["name"], "photos");
  EXPECT_EQ(first["stages"].back()["name"], "publication");
  EXPECT_GT(first["stages"].back()["processorSeconds"], 0.0);
}

TEST_F(MapFolders, JoinPartByPart) {
  testing::WriteFolder(PhotoScene(7), testing::Walk(17), dir_.path() / "sunday");
  // Two ends of the wall, each with an error of its positions of its own.
  std::vector<Shot> ends = testing::Walk(16);
  for (int i = 0; i < 16; ++i) {
    Shot& shot = ends[i];
    shot.x_in_enu = {i < 8 ? -16.0 + i : 1.0 + i, 0.5 + 0.2 * (i % 2), 1.7};
    shot.gps_error_m = 0.1 * shot.gps_error_m +
                       (i < 8 ? Eigen::Vector3d(1.2, 0.6, 0.3) : Eigen::Vector3d(-0.9, -0.8, 0.2));
    shot.exif.error_m = 0.7;
  }
  testing::WriteFolder(PhotoScene(7), ends, dir_.path() / "ends");
  const std::vector<MapSessionResult> sessions = Map({"sunday", "ends"});
  ASSERT_EQ(sessions.size(), 2u);
  ASSERT_TRUE(sessions[1].is_in_map) << sessions[1].problem;
  EXPECT_EQ(sessions[1].mapped.num_mapped, 16);
  ASSERT_EQ(sessions[1].mapped.segments.size(), 2u);
  const auto centers = CentersIn("town.gpkg");
  for (const SegmentReport& segment : sessions[1].mapped.segments) {
    EXPECT_EQ(segment.problem, "");
    EXPECT_GT(segment.moved_by_map_m, 0.3);
  }
  // The two ends are as far from each other as they are, by the size of the map.
  const auto distance = [&](const std::string& p, const std::string& q) {
    return (centers.at(p) - centers.at(q)).norm();
  };
  const double size = distance("sunday/photo100.png", "sunday/photo116.png") / 32.0;
  EXPECT_NEAR(distance("ends/photo100.png", "ends/photo115.png") / 32.0, size, 0.005);
}

// Six photos within 4 m, with positions as phones have them.
std::vector<Shot> Corner(double east_m = 0.0) {
  std::vector<Shot> corner = testing::Walk(6);
  for (int i = 0; i < 6; ++i) {
    Shot& shot = corner[i];
    shot.x_in_enu = {east_m - 2.0 + 0.8 * i, 0.5 + 0.3 * (i % 2), 1.7};
    shot.gps_error_m = {3.0 * (i % 3 - 1), 2.0 - i, 1.5 * (i % 2)};
    shot.exif.error_m = 5.0;
  }
  return corner;
}

TEST_F(MapFolders, WhosePositionsDoNotTellTheirScaleJoinByTheirPhotos) {
  testing::WriteFolder(PhotoScene(7), Corner(), dir_.path() / "corner");
  testing::ExpectError([&] { Map({"corner"}); }, ErrorCode::kBadInput,
                       "do not determine the scale");
  testing::WriteFolder(PhotoScene(7), testing::Walk(17), dir_.path() / "sunday");
  const std::vector<MapSessionResult> sessions = Map({"corner", "sunday"});
  ASSERT_EQ(sessions.size(), 2u);
  ASSERT_EQ(sessions[1].name, "corner");
  ASSERT_TRUE(sessions[1].is_in_map) << sessions[1].problem;
  EXPECT_EQ(sessions[1].mapped.num_mapped, 6);
  EXPECT_TRUE(sessions[1].mapped.left_out.empty());
  EXPECT_EQ(sessions[1].mapped.cameras.size(), 1u);
  EXPECT_THAT(sessions[1].mapped.notes,
              ::testing::Contains(HasSubstr("the map places 6 photos whose positions do not: "
                                            "georegistration: the 6 known positions")));
  const nlohmann::ordered_json json = MapSessionJson(sessions[1]);
  EXPECT_EQ(json["photos"]["segments"][0]["placedBy"], "map");
  EXPECT_EQ(json["photos"]["scale"], "map");
  const auto centers = CentersIn("town.gpkg");
  const auto distance = [&](const std::string& p, const std::string& q) {
    return (centers.at(p) - centers.at(q)).norm();
  };
  const double size = distance("sunday/photo100.png", "sunday/photo116.png") / 32.0;
  EXPECT_NEAR(distance("corner/photo100.png", "corner/photo104.png") / 3.2, size, 0.02);
}

// The first session of a new map has a part without a place, and only a later one shows it.
TEST_F(MapFolders, GetPartsThatALaterFolderShows) {
  std::vector<Shot> shots = testing::Walk(20, -8.0);
  for (int i = 0; i < 20; ++i) {
    shots[i].x_in_enu.x() = -18.0 + i;
  }
  for (Shot shot : Corner(14.0)) {
    shot.name = "corner_" + shot.name;
    shots.push_back(shot);
  }
  testing::WriteFolder(PhotoScene(7), shots, dir_.path() / "saturday");
  testing::WriteFolder(PhotoScene(7), testing::Walk(17), dir_.path() / "sunday");
  MapSessionArguments arguments = Arguments({"sunday", "saturday"});
  arguments.archive_path = dir_.File("archive");
  const std::vector<MapSessionResult> sessions = MakeMapSessions(arguments, {});
  ASSERT_EQ(sessions.size(), 2u);
  ASSERT_EQ(sessions[0].name, "saturday");
  ASSERT_TRUE(sessions[1].is_in_map) << sessions[1].problem;
  EXPECT_EQ(sessions[0].mapped.num_mapped, 26);
  EXPECT_TRUE(sessions[0].mapped.left_out.empty());
  ASSERT_EQ(sessions[0].mapped.segments.size(), 2u);
  EXPECT_TRUE(sessions[0].mapped.segments[1].is_placed_by_map);
  EXPECT_FALSE(sessions[0].report.replaced_session);
  const auto centers = CentersIn("town.gpkg");
  EXPECT_EQ(centers.size(), 43u);
  const auto distance = [&](const std::string& p, const std::string& q) {
    return (centers.at(p) - centers.at(q)).norm();
  };
  const double size = distance("sunday/photo100.png", "sunday/photo116.png") / 32.0;
  EXPECT_NEAR(distance("saturday/photo100.png", "saturday/corner_photo104.png") / size,
              (shots[24].x_in_enu - shots[0].x_in_enu).norm(), 0.2);
  // The session is in the archive once.
  const auto files = std::filesystem::directory_iterator(arguments.archive_path);
  EXPECT_EQ(std::distance(begin(files), end(files)), 2);
}

// As above, but the walk of the first session shows another wall, which no other session shows.
TEST_F(MapFolders, DoNotGetPartsThatWouldTurnAWalkOverNewGround) {
  constexpr double kEastM = 100.0;
  testing::WriteFolder(PhotoScene(9, 1.5, kEastM), testing::Walk(20, kEastM),
                       dir_.path() / "saturday");
  std::vector<Shot> corner = Corner();
  for (Shot& shot : corner) {
    shot.name = "corner_" + shot.name;
  }
  testing::WriteFolder(PhotoScene(7), corner, dir_.path() / "saturday");
  testing::WriteFolder(PhotoScene(7), testing::Walk(17), dir_.path() / "sunday");
  const std::vector<MapSessionResult> sessions = Map({"sunday", "saturday"});
  ASSERT_EQ(sessions.size(), 2u);
  ASSERT_EQ(sessions[0].name, "saturday");
  ASSERT_TRUE(sessions[1].is_in_map) << sessions[1].problem;
  EXPECT_EQ(sessions[0].mapped.num_mapped, 20);
  EXPECT_EQ(sessions[0].mapped.left_out.size(), 6u);
  ASSERT_EQ(sessions[0].mapped.segments.size(), 2u);
  EXPECT_THAT(sessions[0].mapped.segments[1].problem,
              HasSubstr("The whole map sees it, but no part that is published"));
  EXPECT_EQ(CentersIn("town.gpkg").size(), 37u);
}

TEST_F(MapFolders, WhosePositionsDoNotTellTheirScaleAreNotPlacedWhereTheMapShowsAnotherWall) {
  Map({"tuesday"});
  testing::WriteFolder(PhotoScene(8), Corner(), dir_.path() / "elsewhere");
  testing::ExpectError([&] { Map({"elsewhere"}); }, ErrorCode::kConflict,
                       "do not determine the scale; give positions farther apart or more accurate "
                       "ones. The map does not place it, either: it recognizes 0 of 6 photos");
  EXPECT_EQ(CentersIn("town.gpkg").size(), 11u);
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
