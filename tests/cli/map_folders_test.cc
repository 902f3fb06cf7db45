// `cairn map` of several folders: each becomes a session of one map.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "cli/map_session.h"
#include "core/error.h"
#include "mapping/photo_scene.h"
#include "support/expect_error.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;
using testing::PhotoScene;
using testing::Shot;

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

  MapSessionArguments Arguments(const std::vector<std::string>& folders,
                                const std::string& map_name = "town.gpkg") const {
    MapSessionArguments arguments;
    arguments.session.map_path = dir_.File(map_name);
    arguments.session.options.mapping.sift.max_features = 1000;
    arguments.session.options.ingest.num_threads = 2;
    arguments.session.options.ingest.recorded_at = "2026-01-31T12:00:00Z";
    for (const std::string& folder : folders) {
      arguments.input.paths.push_back(dir_.File(folder));
    }
    arguments.input.work_dir = dir_.File("w");
    return arguments;
  }

  std::vector<MapSessionResult> Map(const std::vector<std::string>& folders,
                                    const std::string& map_name = "town.gpkg") const {
    return MakeMapSessions(Arguments(folders, map_name), {});
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
