// Tests in which order the sessions of `cairn map` join the map.
#include "cli/publish_in_turn.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "ingest/session_refused.h"
#include "support/expect_error.h"

namespace cairn {
namespace {

using Names = std::vector<std::string>;

MapSessionResult Mapped(const std::string& name, int num_photos) {
  MapSessionResult session;
  session.name = session.session.options.session_name = name;
  session.is_mapped = true;
  session.mapped.num_mapped = num_photos;
  session.session.options.joining = SessionJoining::kJoin;
  return session;
}

bool Has(const Names& names, const std::string& one) {
  return std::find(names.begin(), names.end(), one) != names.end();
}

// A map that anchors a session if it has one of its neighbors, and takes those of `grounds` where
// it knows nothing.
class Town {
 public:
  Town(std::map<std::string, Names> neighbors, Names grounds)
      : neighbors_(std::move(neighbors)), grounds_(std::move(grounds)) {}

  Names PublishAll(std::vector<MapSessionResult>* sessions, bool is_empty = true) {
    SortSessions(sessions);
    PublishInTurn([this](MapSessionResult* result) { return Publish(result->session); }, is_empty,
                  sessions);
    return published_;
  }

 private:
  IngestReport Publish(const PlacedReconstruction& session) {
    const std::string& name = session.options.session_name;
    const Names& neighbors = neighbors_[name];
    const bool is_anchored =
        std::any_of(neighbors.begin(), neighbors.end(),
                    [&](const std::string& other) { return Has(published_, other); });
    const bool stands_alone =
        session.options.agreement.unanchored == Unanchored::kRefuse && Has(grounds_, name);
    if (!is_anchored && !stands_alone) {
      throw SessionRefused(name + " is not anchored");
    }
    published_.push_back(name);
    return {};
  }

  std::map<std::string, Names> neighbors_;
  Names grounds_, published_;
};

TEST(PublishInTurn, SessionOnNewGroundWaitsForTheOneThatConnectsIt) {
  for (const bool reversed : {false, true}) {
    std::vector<MapSessionResult> sessions = {Mapped("a", 30), Mapped("b", 10), Mapped("c", 20)};
    if (reversed) {
      std::reverse(sessions.begin(), sessions.end());
    }
    Town town({{"b", {"a"}}, {"c", {"b"}}}, {"a", "c"});
    EXPECT_EQ(town.PublishAll(&sessions), (Names{"a", "b", "c"}));
  }
}

TEST(PublishInTurn, SessionsThatMeetNothingStandByTheirPositionsMostPhotosFirst) {
  std::vector<MapSessionResult> sessions = {Mapped("b", 10), Mapped("a", 10), Mapped("c", 11)};
  Town town({}, {"a", "b", "c"});
  EXPECT_EQ(town.PublishAll(&sessions), (Names{"c", "a", "b"}));
}

TEST(PublishInTurn, TriesAgainWhatWasRefusedAndElseSaysWhy) {
  std::vector<MapSessionResult> sessions = {Mapped("a", 30), Mapped("lost", 40), Mapped("b", 20)};
  Town town({{"b", {"a"}}, {"lost", {"nowhere"}}}, {"a"});
  EXPECT_EQ(town.PublishAll(&sessions), (Names{"a", "b"}));
  EXPECT_EQ(sessions.front().problem, "lost is not anchored");
  EXPECT_FALSE(sessions.front().is_in_map);
  EXPECT_TRUE(sessions.back().is_in_map);
  EXPECT_TRUE(sessions.back().problem.empty());
}

TEST(PublishInTurn, FolderWithoutAModelStaysOut) {
  std::vector<MapSessionResult> sessions = {Mapped("a", 30), MapSessionResult()};
  sessions[1].name = "blurred";
  sessions[1].problem = "2 of 2 photos can be read";
  Town town({}, {"a", ""});
  EXPECT_EQ(town.PublishAll(&sessions), (Names{"a"}));
  EXPECT_EQ(sessions[1].problem, "2 of 2 photos can be read");
}

TEST(PublishInTurn, ThrowsWithAllProblemsIfNoSessionIsTaken) {
  std::vector<MapSessionResult> sessions = {Mapped("a", 40), Mapped("b", 40)};
  Town town({}, {});
  testing::ExpectError([&] { town.PublishAll(&sessions, false); }, ErrorCode::kConflict,
                       "none of the 2 sessions, and is as before; a: a is not anchored; b: b is");
}

TEST(PublishInTurn, SessionThatIsAloneThrowsItsOwnProblem) {
  std::vector<MapSessionResult> sessions = {Mapped("a", 40)};
  Town town({}, {});
  testing::ExpectError([&] { town.PublishAll(&sessions, false); }, ErrorCode::kConflict,
                       "a is not anchored");
}

TEST(PublishInTurn, OtherFailuresEndTheCommand) {
  // A conflict may be that of another update, which holds the map.
  for (const ErrorCode code : {ErrorCode::kIo, ErrorCode::kConflict}) {
    std::vector<MapSessionResult> sessions = {Mapped("a", 40), Mapped("b", 30)};
    int num_tried = 0;
    testing::ExpectError(
        [&] {
          PublishInTurn(
              [&](MapSessionResult*) -> IngestReport {
                ++num_tried;
                throw Error(code, "no luck");
              },
              true, &sessions);
        },
        code, "no luck");
    EXPECT_EQ(num_tried, 1);
    EXPECT_TRUE(sessions.front().problem.empty());
  }
}

}  // namespace
}  // namespace cairn
