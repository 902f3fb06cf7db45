// Plans that are built by tasks and published, against `IngestSession`.
#include "ingest/plan/run_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "core/error.h"
#include "core/file_bytes.h"
#include "ingest/ingest_session.h"
#include "ingest/plan/built_tile_codec.h"
#include "ingest/plan/plan_folder.h"
#include "ingest/remove_session.h"
#include "support/map_place.h"
#include "support/reconstruction_builder.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::StreetWorld;

StreetWorld Street(uint64_t view_seed, double north_m = 0.0) {
  testing::StreetWorldOptions options;
  options.length_m = 160.0;  // Longer than a tile.
  options.num_landmarks = 1600;
  options.view_seed = view_seed;
  options.origin = Geodetic::FromDegrees(47.3769 + north_m / 111'200.0, 8.5417, 408.0);
  return StreetWorld(options);
}

IngestOptions PlanOptionsFor(const std::string& session_name) {
  IngestOptions options;
  options.session_name = session_name;
  options.recorded_at = "2026-01-31T12:00:00Z";
  options.codebook.max_training_descriptors = 1000;
  return options;
}

struct Failure {
  std::optional<ErrorCode> code;
  std::string message;
};

Failure FailureOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return {error.code(), error.what()};
  }
  return {};
}

// Everything in a map but the times at which it was written.
using TileRow = std::tuple<TileId, std::string, int64_t, double, double>;
using KeyframeRow = std::tuple<int64_t, int64_t, TileId, std::string, double, double>;
struct Contents {
  std::vector<TileRow> tiles;
  std::vector<KeyframeRow> keyframes;
  std::vector<std::tuple<int64_t, std::string, std::string>> sessions;
  LandmarkId next_landmark{};
  bool operator==(const Contents&) const = default;
};

Contents ContentsOfTables(const MapStore& store) {
  const MapSnapshot snapshot = store.Snapshot();
  Contents contents;
  contents.next_landmark = snapshot.NextLandmarkId();
  for (const TileRecord& tile : snapshot.AllTiles(1000)) {
    contents.tiles.emplace_back(tile.tile_id, tile.digest, tile.num_keyframes, tile.min_h_m,
                                tile.landmark_bounds.south_rad);
  }
  for (const SessionRecord& session : snapshot.Sessions()) {
    contents.sessions.emplace_back(Value(session.id), session.name, session.content_digest);
    for (const KeyframeRecord& keyframe : snapshot.KeyframesOfSession(session.id)) {
      contents.keyframes.emplace_back(
          Value(keyframe.id), Value(keyframe.session_id), keyframe.tile_id, keyframe.image_name,
          keyframe.cam_from_ecef.rotation.x(), keyframe.cam_from_ecef.translation.x());
    }
  }
  return contents;
}

class PlanTest : public testing::MapPlaceTest {
 protected:
  static IngestReport Ingest(const StreetWorld& world, const IngestOptions& options,
                             MapStore* store) {
    return IngestSession(world.Reconstruct(), world.EcefFromWorld(), options, store, {});
  }

  // Plans into the folder `name` and returns its path.
  std::string Plan(const StreetWorld& world, const IngestOptions& options, const std::string& name,
                   MapStore* store) {
    const std::string path = plans_.File(name);
    PreparePlanFolder(path);
    const Reconstruction reconstruction = world.Reconstruct();
    WritePlan(PlanSession(reconstruction, world.EcefFromWorld(), options, store, {}), store->path(),
              path, {});
    return path;
  }

  static ShareReport Build(const std::string& path, int64_t index = 0, int64_t count = 1) {
    PlanFolder folder(path);
    return BuildShare(&folder, {index, count}, {});
  }

  static IngestReport Publish(const std::string& path, MapStore* store, int64_t num_tasks = 0) {
    PlanFolder folder(path);
    return PublishPlan(&folder, num_tasks, store, {}, {});
  }

  // A map with one session.
  MapStore MakeMap(const std::string& name) {
    MapStore store = MapStore::Create(Place(name));
    Ingest(Street(1), PlanOptionsFor("first"), &store);
    return store;
  }

  testing::TempDir plans_;
};
CAIRN_ON_BOTH_KINDS_OF_MAPS(PlanTest);

TEST_P(PlanTest, AnyNumberOfTasksMakesTheMapOfIngest) {
  MapStore sequential = MakeMap("sequential");
  IngestOptions threaded = PlanOptionsFor("second");
  threaded.num_threads = 3;
  const IngestReport expected = Ingest(Street(2), threaded, &sequential);
  ASSERT_GE(expected.num_tiles_written, 2);
  ASSERT_GT(expected.changes.num_merged, 100);
  for (const int64_t count : {1, 2, 5}) {
    MapStore spread = MakeMap("spread" + std::to_string(count));
    const std::string plan =
        Plan(Street(2), PlanOptionsFor("second"), std::to_string(count), &spread);
    int64_t num_built = Build(plan, 0, count).num_built;
    for (int64_t index = 0; index < count; ++index) {
      num_built += Build(plan, index, count).num_built;  // The first task runs twice.
    }
    EXPECT_EQ(num_built, static_cast<int64_t>(PlanFolder(plan).plan().tiles.size()));
    const IngestReport report = Publish(plan, &spread);
    EXPECT_EQ(ContentsOfTables(spread), ContentsOfTables(sequential)) << count;
    EXPECT_EQ(report.map_version, expected.map_version);
    EXPECT_EQ(report.changes.num_merged, expected.changes.num_merged);
    EXPECT_EQ(report.comparison.num_localized, expected.comparison.num_localized);
    EXPECT_EQ(report.num_payload_bytes, expected.num_payload_bytes);
    EXPECT_TRUE(spread.Check({}).problems.empty());
  }
}

TEST_P(PlanTest, TheFirstSessionBringsItsCodebook) {
  MapStore sequential = MapStore::Create(Place("sequential"));
  MapStore spread = MapStore::Create(Place("spread"));
  Ingest(Street(1), PlanOptionsFor("first"), &sequential);
  const std::string plan = Plan(Street(1), PlanOptionsFor("first"), "plan", &spread);
  EXPECT_EQ(spread.Snapshot().CurrentCodebook(), nullptr);
  Build(plan);
  Publish(plan, &spread);
  EXPECT_EQ(ContentsOfTables(spread), ContentsOfTables(sequential));
  EXPECT_EQ(spread.Snapshot().CurrentCodebook()->id, sequential.Snapshot().CurrentCodebook()->id);
}

TEST_P(PlanTest, AReplacedSessionLeavesItsTiles) {
  MapStore sequential = MakeMap("sequential");
  MapStore spread = MakeMap("spread");
  const StreetWorld elsewhere = Street(3, 400.0);
  const IngestReport expected = Ingest(elsewhere, PlanOptionsFor("first"), &sequential);
  const std::string plan = Plan(elsewhere, PlanOptionsFor("first"), "plan", &spread);
  Build(plan);
  EXPECT_EQ(Publish(plan, &spread).replaced_session, expected.replaced_session);
  EXPECT_TRUE(expected.replaced_session);
  EXPECT_EQ(ContentsOfTables(spread), ContentsOfTables(sequential));
}

TEST_P(PlanTest, OfTwoPlansOfATileOneWins) {
  MapStore store = MakeMap("map");
  const std::string winner = Plan(Street(2), PlanOptionsFor("second"), "winner", &store);
  const std::string loser = Plan(Street(3), PlanOptionsFor("third"), "loser", &store);
  Build(winner);
  Build(loser);
  Publish(winner, &store);
  const Contents contents = ContentsOfTables(store);
  const Failure failure = FailureOf([&] { Publish(loser, &store); });
  EXPECT_EQ(failure.code, ErrorCode::kConflict);
  const PlanFolder folder(loser);
  for (const PlannedTile& tile : folder.plan().tiles) {
    EXPECT_THAT(failure.message, HasSubstr(tile.tile_id.ToString()));
  }
  EXPECT_EQ(ContentsOfTables(store), contents);
  const std::string again = Plan(Street(3), PlanOptionsFor("third"), "again", &store);
  Build(again);
  Publish(again, &store);
  EXPECT_TRUE(store.Check({}).problems.empty());
}

TEST_P(PlanTest, PlansOfOtherTilesAreAllPublished) {
  MapStore store = MakeMap("map");
  const std::string here = Plan(Street(2), PlanOptionsFor("here"), "here", &store);
  const std::string there = Plan(Street(3, 2000.0), PlanOptionsFor("there"), "there", &store);
  Build(here);
  Build(there);
  Publish(there, &store);
  Publish(here, &store);
  EXPECT_EQ(store.Snapshot().Sessions().size(), 3u);
  EXPECT_TRUE(store.Check({}).problems.empty());
}

TEST_P(PlanTest, AMissingOrDamagedResultIsNamedWithItsTask) {
  MapStore store = MakeMap("map");
  const std::string plan = Plan(Street(2), PlanOptionsFor("second"), "plan", &store);
  const Contents contents = ContentsOfTables(store);
  Build(plan, 1, 2);
  const PlanFolder folder(plan);
  const std::string missing =
      folder.plan().tiles[TilesOfTask(folder.plan(), 0, 2).front()].tile_id.ToString();
  Failure failure = FailureOf([&] { Publish(plan, &store, 2); });
  EXPECT_EQ(failure.code, ErrorCode::kConflict);
  EXPECT_THAT(failure.message,
              AllOf(HasSubstr(missing), HasSubstr("--count 2"), HasSubstr("--index 0")));
  EXPECT_THAT(FailureOf([&] { Publish(plan, &store); }).message, HasSubstr("--index 0 --count 1"));

  Build(plan, 0, 2);
  std::ofstream(plan + "/results/" + missing, std::ios::app) << "x";
  failure = FailureOf([&] { Publish(plan, &store); });
  EXPECT_EQ(failure.code, ErrorCode::kConflict);
  EXPECT_THAT(failure.message, HasSubstr(missing));
  EXPECT_EQ(ContentsOfTables(store), contents);
  EXPECT_EQ(Build(plan).num_built, 1);
  Publish(plan, &store);
}

TEST_P(PlanTest, APlanIsPublishedOnce) {
  MapStore store = MakeMap("map");
  const std::string plan = Plan(Street(2), PlanOptionsFor("second"), "plan", &store);
  Build(plan);
  Publish(plan, &store);
  EXPECT_FALSE(fs::exists(plan + "/shards"));
  const Contents contents = ContentsOfTables(store);
  const Failure failure = FailureOf([&] { Publish(plan, &store); });
  EXPECT_EQ(failure.code, ErrorCode::kConflict);
  EXPECT_THAT(failure.message, HasSubstr("already"));
  EXPECT_EQ(ContentsOfTables(store), contents);
}

TEST_P(PlanTest, ASessionThatTheMapHasNeedsNoTiles) {
  MapStore store = MakeMap("map");
  const std::string plan = Plan(Street(1), PlanOptionsFor("first"), "plan", &store);
  EXPECT_EQ(Build(plan).num_tiles, 0);
  EXPECT_TRUE(Publish(plan, &store).is_unchanged);
  EXPECT_EQ(store.Snapshot().version(), MapVersion(2));
}

TEST_P(PlanTest, IsRefusedAfterItsSessionChanged) {
  MapStore store = MakeMap("map");
  Ingest(Street(2, 2000.0), PlanOptionsFor("second"), &store);
  const std::string replaces = Plan(Street(3), PlanOptionsFor("first"), "replaces", &store);
  const std::string adds = Plan(Street(4, 4000.0), PlanOptionsFor("new"), "adds", &store);
  Build(replaces);
  Build(adds);
  RemoveSession("first", &store);
  Ingest(Street(5, 6000.0), PlanOptionsFor("new"), &store);
  EXPECT_THAT(FailureOf([&] { Publish(replaces, &store); }).message, HasSubstr("was removed"));
  EXPECT_THAT(FailureOf([&] { Publish(adds, &store); }).message, HasSubstr("of this name"));
}

TEST_P(PlanTest, IsRefusedByAnotherMap) {
  MapStore store = MakeMap("map");
  const std::string plan = Plan(Street(2), PlanOptionsFor("second"), "plan", &store);
  Build(plan);
  MapStore other = MapStore::Create(Place("other"));
  const Failure failure = FailureOf([&] { Publish(plan, &other); });
  EXPECT_EQ(failure.code, ErrorCode::kConflict);
  EXPECT_EQ(other.Snapshot().version(), MapVersion(1));
}

class PlanFolderTest : public PlanTest {
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
    const std::string before = ReadTextFile(file, 1 << 28);
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
