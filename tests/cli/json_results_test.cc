// Tests --json of the verbs that change maps: the document is all that stands on stdout.
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "cli/run_cairn.h"
#include "ingest/ingest_session.h"
#include "storage/map/map_store.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

using Json = nlohmann::json;

class JsonResults : public ::testing::Test {
 protected:
  JsonResults() {
    StreetWorldOptions world_options;
    world_options.length_m = 24.0;
    world_options.num_landmarks = 300;
    const StreetWorld world(world_options);
    for (const auto& [path, session] : {std::pair(map_, "monday"), std::pair(other_, "tuesday")}) {
      MapStore::Create(path);
      MapStore store = MapStore::Open(path, OpenMode::kReadWrite);
      IngestOptions options;
      options.session_name = session;
      IngestSession(world.Reconstruct(), world.EcefFromWorld(), options, &store, {});
    }
  }

  Json Run(std::vector<std::string> arguments, int exit_code = 0) {
    arguments.push_back("--json");
    const Finished finished = RunCairn(arguments);
    EXPECT_EQ(finished.exit_code, exit_code) << finished.err;
    return Json::parse(finished.out);
  }

  TempDir dir_;
  std::string map_ = dir_.File("map.gpkg");
  std::string other_ = dir_.File("other.gpkg");
};

TEST_F(JsonResults, OfVerbsThatReadOrCopyAMap) {
  const Json info = Run({"info", map_});
  const Json check = Run({"check", map_});
  EXPECT_EQ(check["sound"], true);
  EXPECT_EQ(check["problems"], Json::array());
  EXPECT_GE(check["contentsOfTilesChecked"], info["tiles"]);
  const std::string copy_path = dir_.File("copy.gpkg");
  const Json copy = Run({"copy", map_, copy_path});
  EXPECT_EQ(copy["map"], copy_path);
  EXPECT_EQ(copy["mapVersion"], info["version"]);
  EXPECT_EQ(copy["landmarks"], info["landmarks"]);
  const Json part =
      Run({"extract", map_, "--bbox", "-90,-180,90,180", "--out", dir_.File("part.gpkg")});
  EXPECT_EQ(part["tiles"], info["tiles"]);
  const Json merged = Run({"merge", map_, other_, "--apart", "--out", dir_.File("both.gpkg")});
  EXPECT_EQ(merged["sessions"], 2);
  EXPECT_TRUE(merged["comparison"].is_null());
}

TEST_F(JsonResults, OfSqlIsAnArrayOfRows) {
  const Json rows = Run({"sql", map_, "SELECT name FROM v_sessions"});
  EXPECT_EQ(rows, Json::parse(R"([{"name": "monday"}])"));
  const Finished both = RunCairn({"sql", map_, "SELECT 1", "--json", "--format", "csv"});
  EXPECT_EQ(both.exit_code, 2);
}

TEST_F(JsonResults, OfVerbsThatChangeAMap) {
  const Json info = Run({"info", map_});
  const int64_t version = info["version"];
  const Json removed = Run({"remove", map_, "monday"});
  EXPECT_EQ(removed["mapVersion"], version + 1);
  EXPECT_EQ(removed["tilesRemoved"], info["tiles"]);
  const Json back = Run({"rollback", map_, std::to_string(version)});
  EXPECT_EQ(back["mapVersion"], version + 2);
  EXPECT_EQ(back["contentOfVersion"], version);
  const Json recoded = Run({"recode", map_, "--codebook", "shipped"});
  EXPECT_EQ(recoded["codebook"], Run({"info", map_})["codebook"]);
  const Json pruned = Run({"prune", map_, "--keep", "1"});
  EXPECT_GT(pruned["versionsDeleted"], 0);
  const Json compact = Run({"compact", map_});
  EXPECT_LE(compact["fileBytes"], compact["fileBytesBefore"]);
}

TEST_F(JsonResults, OfACheckListTheProblems) {
  if (std::system("command -v sqlite3 >/dev/null") != 0) {
    GTEST_SKIP() << "the sqlite3 shell is not installed";
  }
  ASSERT_EQ(RunCairn({"copy", map_, dir_.File("broken.gpkg")}).exit_code, 0);
  ASSERT_EQ(std::system(("sqlite3 " + dir_.File("broken.gpkg") +
                         " 'UPDATE cairn_payloads SET bytes = substr(bytes, 1, 40)'")
                            .c_str()),
            0);
  const Json check = Run({"check", dir_.File("broken.gpkg")}, 5);
  EXPECT_EQ(check["sound"], false);
  EXPECT_GT(check["problems"].size(), 0u);
}

TEST(JsonOfKeys, ListsWhatTheTableLists) {
  TempDir dir;
  const std::string keys = dir.File("keys.json");
  ASSERT_EQ(RunCairn({"keys", "new", keys, "--label", "acme", "--rate", "5"}).exit_code, 0);
  const Json list = Json::parse(RunCairn({"keys", "list", keys, "--json"}).out);
  EXPECT_EQ(list[0]["label"], "acme");
  EXPECT_EQ(list[0]["ratePerS"], 5.0);
  EXPECT_TRUE(list[0]["quotaPerDay"].is_null());
}

}  // namespace
}  // namespace cairn::testing
