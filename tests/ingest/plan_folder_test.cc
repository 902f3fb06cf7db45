#include "ingest/maps/plan_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/file_bytes.h"
#include "ingest/maps/built_tile_codec.h"
#include "ingest/maps/run_plan.h"
#include "ingest/plan_fixture.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using testing::Failure;
using testing::FailureOf;
using ::testing::HasSubstr;
using testing::PlanOptionsFor;
using testing::Street;

class PlanFolderTest : public testing::PlanFixture {
 protected:
  PlanFolderTest() = default;

  std::string MakePlan() {
    store_.emplace(MapStore::Create(Place("map")));
    return Plan(Street(1), PlanOptionsFor("first"), "plan", &*store_);
  }

  static void Replace(const std::string& path, const std::string& what, const std::string& by) {
    std::string text = ReadTextFile(path, 1 << 24);
    const size_t at = text.find(what);
    ASSERT_NE(at, std::string::npos);
    std::ofstream(path, std::ios::binary) << text.replace(at, what.size(), by);
  }

  std::optional<MapStore> store_;
};
INSTANTIATE_TEST_SUITE_P(, PlanFolderTest, ::testing::Values(testing::MapKind::kFile),
                         testing::NameOfKind);

TEST_P(PlanFolderTest, ATaskMustBeOneOfAll) {
  const std::string plan = MakePlan();
  for (const auto& [index, count] : {std::pair(4, 4), {-1, 4}, {0, 0}, {0, -1}}) {
    EXPECT_EQ(FailureOf([&, i = index, n = count] { Build(plan, i, n); }).code,
              ErrorCode::kInvalidArgument);
  }
}

TEST_P(PlanFolderTest, EveryTileIsInOneTask) {
  const std::string path = MakePlan();
  const SessionPlan plan = PlanFolder(path).plan();
  for (const int64_t count : {1, 2, 7}) {
    std::multiset<size_t> tiles;
    for (int64_t index = 0; index < count; ++index) {
      const std::vector<size_t> of_task = TilesOfTask(plan, index, count);
      tiles.insert(of_task.begin(), of_task.end());
    }
    EXPECT_EQ(tiles.size(), plan.tiles.size());
    EXPECT_EQ(std::set<size_t>(tiles.begin(), tiles.end()).size(), plan.tiles.size());
  }
}

TEST_P(PlanFolderTest, DamagedFilesAreRefused) {
  const std::string plan = MakePlan();
  const std::string tile = PlanFolder(plan).plan().tiles.front().tile_id.ToString();
  for (const std::string& file : {plan + "/shards/" + tile, plan + "/codebook.bin"}) {
    const std::vector<uint8_t> bytes = ReadFileBytes(file, 1 << 28);
    const std::string before(bytes.begin(), bytes.end());
    std::ofstream(file, std::ios::app) << "x";
    const Failure failure = FailureOf([&] { Build(plan); });
    EXPECT_EQ(failure.code, ErrorCode::kBadInput);
    EXPECT_THAT(failure.message, HasSubstr(file));
    fs::remove(file);
    EXPECT_EQ(FailureOf([&] { Build(plan); }).code, ErrorCode::kBadInput);
    std::ofstream(file, std::ios::binary) << before;
  }
  Build(plan);
  Replace(plan + "/plan.json", "\"work\"", "\"wark\"");
  EXPECT_EQ(FailureOf([&] { Build(plan); }).code, ErrorCode::kBadInput);
}

TEST_P(PlanFolderTest, AResultWithImpossibleNumbersIsRefused) {
  const std::string digest(32, '0');
  const TileId tile_id = PlanFolder(MakePlan()).plan().tiles.front().tile_id;
  BuiltTile built;
  built.tile.encoded.record.tile_id = tile_id;
  const auto decode = [&] {
    DecodeBuiltTile(EncodeBuiltTile(built, digest), digest, tile_id, SessionId(1));
  };
  EXPECT_NO_THROW(decode());
  built.tile.encoded.record.max_h_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(FailureOf(decode).code, ErrorCode::kBadInput);
  built.tile.encoded.record.max_h_m = 0.0;
  built.tile.encoded.record.num_landmarks = -1;
  EXPECT_EQ(FailureOf(decode).code, ErrorCode::kBadInput);
  built.tile.encoded.record.num_landmarks = 0;
  built.tile.changes.num_merged = -1;
  EXPECT_EQ(FailureOf(decode).code, ErrorCode::kBadInput);
}

TEST_P(PlanFolderTest, APlanOfAnotherVersionOfCairnIsRefused) {
  const std::string plan = MakePlan();
  Replace(plan + "/plan.json", "\"cairn\": \"", "\"cairn\": \"9");
  const Failure failure = FailureOf([&] { Build(plan); });
  EXPECT_EQ(failure.code, ErrorCode::kBadInput);
  EXPECT_THAT(failure.message, HasSubstr("one version"));
}

TEST_P(PlanFolderTest, ResultsOfAnotherPlanDoNotCount) {
  const std::string plan = MakePlan();
  Build(plan);
  Replace(plan + "/plan.json", "\"source\": \"\"", "\"source\": \"elsewhere\"");
  EXPECT_EQ(FailureOf([&] { Publish(plan, &*store_); }).code, ErrorCode::kConflict);
  EXPECT_GT(Build(plan).num_built, 0);
}

TEST_P(PlanFolderTest, OnlyWhatAPlanLeftIsRemoved) {
  const std::string path = plans_.File("folder");
  fs::create_directories(path + "/shards");
  std::ofstream(path + "/shards/32N-03104-35120") << "of a plan that died";
  PreparePlanFolder(path);
  EXPECT_TRUE(fs::is_empty(path + "/shards"));
  EXPECT_EQ(FailureOf([&] { PlanFolder folder(path); }).code, ErrorCode::kNotFound);

  std::ofstream(path + "/thesis.tex") << "of a user";
  EXPECT_EQ(FailureOf([&] { PreparePlanFolder(path); }).code, ErrorCode::kConflict);
  EXPECT_TRUE(fs::exists(path + "/thesis.tex"));

  const std::string plan = MakePlan();
  EXPECT_EQ(FailureOf([&] { PreparePlanFolder(plan); }).code, ErrorCode::kConflict);
  EXPECT_TRUE(fs::exists(plan + "/plan.json"));
}

// Who may write to the folder may not choose files of the user that Cairn overwrites or removes.
TEST_P(PlanFolderTest, LinksAreNotFollowed) {
  const std::string elsewhere = plans_.File("elsewhere");
  fs::create_directory(elsewhere);
  std::ofstream(elsewhere + "/thesis.tex") << "of a user";
  const std::string unfinished = plans_.File("unfinished");
  fs::create_directory(unfinished);
  fs::create_directory_symlink(elsewhere, unfinished + "/shards");
  PreparePlanFolder(unfinished);
  EXPECT_FALSE(fs::is_symlink(unfinished + "/shards"));
  EXPECT_TRUE(fs::exists(elsewhere + "/thesis.tex"));

  const std::string plan = MakePlan();
  const std::string tile = PlanFolder(plan).plan().tiles.front().tile_id.ToString();
  fs::copy_file(plan + "/shards/" + tile, elsewhere + "/shard");
  fs::remove(plan + "/shards/" + tile);
  fs::create_symlink(elsewhere + "/shard", plan + "/shards/" + tile);
  EXPECT_THAT(FailureOf([&] { Build(plan); }).message, HasSubstr("is a link"));
  fs::remove_all(plan + "/results");
  fs::create_directory_symlink(elsewhere, plan + "/results");
  EXPECT_THAT(FailureOf([&] { PlanFolder folder(plan); }).message, HasSubstr("is a link"));
}

TEST_P(PlanFolderTest, UnfinishedFilesOfDeadTasksAreRemoved) {
  const std::string plan = MakePlan();
  const std::string part =
      plan + "/results/" + PlanFolder(plan).plan().tiles.front().tile_id.ToString() + ".1.part";
  std::ofstream(part) << "half a tile";
  Build(plan);
  EXPECT_FALSE(fs::exists(part));
}

TEST_P(PlanFolderTest, AnOlderCopyOfTheMapRefusesThePlan) {
  MapStore store = MakeMap("map");
  const std::string copy = Place("copy");
  fs::copy_file(store.path(), copy);
  const std::string plan = Plan(Street(2), PlanOptionsFor("second"), "plan", &store);
  Build(plan);
  MapStore older = MapStore::Open(copy, OpenMode::kReadWrite);
  const Failure failure = FailureOf([&] { Publish(plan, &older); });
  EXPECT_EQ(failure.code, ErrorCode::kConflict);
  EXPECT_THAT(failure.message, HasSubstr("older than the plan"));
  Publish(plan, &store);
}

}  // namespace
}  // namespace cairn
