#include "lab/experiments/measure/link_judge.h"

#include <gtest/gtest.h>

#include <vector>

namespace cairn {
namespace {

// A landmark of a session: its id in the map (0: dropped), its thing and its view.
struct JudgedLandmark {
  uint64_t id, thing, view;
};

void Judge(const std::vector<JudgedLandmark>& landmarks, uint64_t first_new_landmark,
           const std::unordered_set<uint64_t>& ids_in_map, LinkJudge* judge) {
  CitySession session;
  IngestReport report;
  report.first_new_landmark = LandmarkId(first_new_landmark);
  for (const JudgedLandmark& landmark : landmarks) {
    session.things.push_back(landmark.thing);
    session.views.push_back(landmark.view);
    report.landmark_ids.push_back(LandmarkId(landmark.id));
  }
  judge->Add(session, report, ids_in_map);
}

class LinkJudgeTest : public ::testing::Test {
 protected:
  // The map drops landmark 3.
  LinkJudgeTest() {
    Judge({{1, 10, 100}, {2, 20, 200}, {3, 30, 300}, {4, 40, 400}}, 1, {1, 2, 4}, &judge_);
  }

  LinkJudge judge_;
};

TEST_F(LinkJudgeTest, AFirstSessionHasNoLinks) {
  EXPECT_EQ(judge_.FalseShare(), 0.0);
  EXPECT_EQ(judge_.FoundShare(), 0.0);
}

TEST_F(LinkJudgeTest, ALinkIsRightIfItJoinsOneThing) {
  Judge({{1, 10, 100}}, 5, {1, 2, 4}, &judge_);
  EXPECT_EQ(judge_.FalseShare(), 0.0);
  EXPECT_EQ(judge_.FoundShare(), 1.0);
}

TEST_F(LinkJudgeTest, ALinkIsFalseIfItJoinsTwoThings) {
  Judge({{2, 99, 999}}, 5, {1, 2, 4}, &judge_);
  EXPECT_EQ(judge_.FalseShare(), 1.0);
  EXPECT_EQ(judge_.FoundShare(), 0.0);
}

TEST_F(LinkJudgeTest, AForgottenLandmarkCannotBeFound) {
  Judge({{1, 10, 100}, {5, 30, 300}}, 5, {1, 2, 4, 5}, &judge_);
  EXPECT_EQ(judge_.FoundShare(), 1.0);
  // Now the map has it.
  Judge({{6, 30, 300}}, 6, {1, 2, 4, 5, 6}, &judge_);
  EXPECT_EQ(judge_.FoundShare(), 0.5);
}

TEST_F(LinkJudgeTest, CountsLinksAndPossibleLinksOverSessions) {
  Judge({{1, 10, 100},   // Right and possible.
         {2, 99, 999},   // False.
         {4, 40, 401},   // Right, but from a view that the map does not know.
         {5, 20, 200},   // Possible and not found.
         {0, 10, 100}},  // Dropped before it could be linked.
        5, {1, 2, 4, 5}, &judge_);
  EXPECT_DOUBLE_EQ(judge_.FalseShare(), 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(judge_.FoundShare(), 1.0 / 2.0);
  Judge({{4, 40, 401},   // The map knows this view now.
         {6, 99, 999}},  // The false link did not make this view known.
        6, {1, 2, 4, 5, 6}, &judge_);
  EXPECT_DOUBLE_EQ(judge_.FalseShare(), 1.0 / 4.0);
  EXPECT_DOUBLE_EQ(judge_.FoundShare(), 2.0 / 3.0);
}

}  // namespace
}  // namespace cairn
