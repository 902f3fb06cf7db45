// Plans that are built by tasks and published, against `IngestSession`.
#include "ingest/maps/run_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <tuple>
#include <vector>

#include "core/error.h"
#include "ingest/ingest_session.h"
#include "ingest/maps/plan_folder.h"
#include "ingest/maps/remove_session.h"
#include "ingest/plan_fixture.h"
#include "support/reconstruction_builder.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using testing::Failure;
using testing::FailureOf;
using ::testing::HasSubstr;
using testing::PlanOptionsFor;
using testing::Street;
using testing::StreetWorld;

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

class PlanTest : public testing::PlanFixture {};
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
  const std::string there = Plan(Street(3, 5000.0), PlanOptionsFor("there"), "there", &store);
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
  Ingest(Street(2, 10'000.0), PlanOptionsFor("second"), &store);
  const std::string replaces = Plan(Street(3), PlanOptionsFor("first"), "replaces", &store);
  const std::string adds = Plan(Street(4, 20'000.0), PlanOptionsFor("new"), "adds", &store);
  Build(replaces);
  Build(adds);
  RemoveSession("first", &store);
  Ingest(Street(5, 30'000.0), PlanOptionsFor("new"), &store);
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

}  // namespace
}  // namespace cairn
