// Tests the gate before a publication: what an update takes from the keyframes of the map.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "ingest/plan_fixture.h"
#include "ingest/session_placement.h"
#include "support/map_place.h"

namespace cairn {
namespace {

using ::testing::AllOf;
using testing::Failure;
using testing::FailureOf;
using ::testing::HasSubstr;
using testing::PlanOptionsFor;
using testing::Street;

class PublicationGate : public testing::PlanFixture {
 protected:
  // The same street 9 m further north, beside what the map knows: two copies of each facade.
  static IngestOptions Beside(const std::string& name) {
    IngestOptions options = PlanOptionsFor(name);
    options.joining = SessionJoining::kApart;
    return options;
  }
};

CAIRN_ON_BOTH_KINDS_OF_MAPS(PublicationGate);

TEST_P(PublicationGate, AsksForASessionThatIsKeptApart) {
  MapStore store = MakeMap("map");
  const KeyframeAnswers answers = Ingest(Street(2, 9.0), Beside("copy"), &store).keyframe_answers;
  EXPECT_EQ(answers.num_asked, 12);
}

TEST(RequireAnswers, RefusesAVersionThatLosesMoreThanItMay) {
  EXPECT_NO_THROW(RequireAnswers({12, 2}, GateOptions(), "session 'a'"));
  EXPECT_NO_THROW(RequireAnswers({100, 20}, GateOptions(), "session 'a'"));
  EXPECT_NO_THROW(RequireAnswers({12, 12}, {.max_lost_share = 1.0}, "session 'a'"));
  const Failure failure = FailureOf([] { RequireAnswers({12, 3}, GateOptions(), "session 'a'"); });
  EXPECT_EQ(failure.code, ErrorCode::kConflict);
  EXPECT_THAT(failure.message,
              AllOf(HasSubstr("session 'a' was not published: with it, the map no longer localizes "
                              "3 of 12 of its own keyframes"),
                    HasSubstr("--force")));
}

TEST_P(PublicationGate, LetsAVersionPassThatLosesNone) {
  MapStore store = MakeMap("map");
  const IngestReport report = Ingest(Street(2), PlanOptionsFor("second"), &store);
  EXPECT_EQ(report.keyframe_answers.num_asked, 12);
  EXPECT_EQ(report.keyframe_answers.num_lost, 0);
}

TEST_P(PublicationGate, AsksForPlans) {
  MapStore store = MakeMap("map");
  const std::string path = Plan(Street(2, 9.0), Beside("copy"), "copy", &store);
  Build(path);
  EXPECT_EQ(Publish(path, &store).keyframe_answers.num_asked, 12);
}

// A budget for a tile that leaves the map too few landmarks for its own photos.
IngestOptions TooSmallFor(const std::string& name) {
  IngestOptions options = PlanOptionsFor(name);
  options.selection.max_descriptors = 40;
  return options;
}

std::vector<std::string> DigestsOf(const MapStore& store) {
  std::vector<std::string> digests;
  for (const TileRecord& tile : store.Snapshot().AllTiles(99)) {
    digests.push_back(tile.digest);
  }
  return digests;
}

TEST_P(PublicationGate, RefusesASessionWithTheFigureAndLeavesTheMapAsItIs) {
  MapStore store = MakeMap("map");
  const MapVersion version = store.Snapshot().version();
  const std::vector<std::string> digests = DigestsOf(store);
  const Failure failure = FailureOf([&] { Ingest(Street(2), TooSmallFor("small"), &store); });
  EXPECT_EQ(failure.code, ErrorCode::kConflict);
  EXPECT_THAT(failure.message, ::testing::ContainsRegex(
                                   "session 'small' was not published: with it, the map no longer "
                                   "localizes [0-9]+ of 12 of its own keyframes near by"));
  EXPECT_EQ(store.Snapshot().version(), version);
  EXPECT_EQ(DigestsOf(store), digests);
  IngestOptions forced = TooSmallFor("small");
  forced.gate.max_lost_share = 1.0;
  EXPECT_GT(Ingest(Street(2), forced, &store).map_version, version);
  EXPECT_NE(DigestsOf(store), digests);
}

TEST_P(PublicationGate, RefusesAPlanUnlessItIsForced) {
  MapStore store = MakeMap("map");
  const MapVersion version = store.Snapshot().version();
  const std::string path = Plan(Street(2), TooSmallFor("small"), "small", &store);
  Build(path);
  EXPECT_THAT(FailureOf([&] { Publish(path, &store); }).message, HasSubstr("no longer localizes"));
  EXPECT_EQ(store.Snapshot().version(), version);
  EXPECT_GT(Publish(path, &store, /*num_tasks=*/0, /*force=*/true).map_version, version);
}

TEST_P(PublicationGate, LetsASessionMoveThatReplacesItself) {
  MapStore store = MakeMap("map");
  const IngestReport report = Ingest(Street(1, 9.0), PlanOptionsFor("first"), &store);
  EXPECT_TRUE(report.replaced_session);
  EXPECT_EQ(report.keyframe_answers.num_asked, 0);
}

}  // namespace
}  // namespace cairn
