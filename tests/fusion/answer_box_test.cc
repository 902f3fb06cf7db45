#include "fusion/estimator/answer_box.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cairn::fusion {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

Answer AnswerTo(int64_t query_id) {
  Answer answer;
  answer.query_id = query_id;
  return answer;
}

TEST(AnswerBox, HandsAnswersOutInTheOrderOfTheirQueries) {
  AnswerBox box;
  for (const int64_t query_id : {5, 2, 9}) {
    EXPECT_EQ(box.Submit(AnswerTo(query_id)), SubmitStatus::kQueued);
  }
  std::vector<int64_t> query_ids;
  for (const Answer& answer : box.TakeAll()) {
    query_ids.push_back(answer.query_id);
  }
  EXPECT_THAT(query_ids, ElementsAre(2, 5, 9));
  EXPECT_THAT(box.TakeAll(), IsEmpty());
}

TEST(AnswerBox, IsFullAtThirtyTwo) {
  AnswerBox box;
  for (int64_t query_id = 1; query_id <= 32; ++query_id) {
    EXPECT_EQ(box.Submit(AnswerTo(query_id)), SubmitStatus::kQueued);
  }
  EXPECT_EQ(box.Submit(AnswerTo(33)), SubmitStatus::kQueueFull);
  EXPECT_EQ(box.TakeAll().size(), 32u);
  EXPECT_EQ(box.Submit(AnswerTo(34)), SubmitStatus::kQueued);
}

TEST(AnswerBox, KeepsTheLastReports) {
  AnswerBox box;
  for (int64_t query_id = 1; query_id <= 70; ++query_id) {
    box.Report({query_id, AnswerOutcome::kNotLocalized, 0});
  }
  const std::vector<AnswerReport> reports = box.TakeReports();
  ASSERT_EQ(reports.size(), 64u);
  EXPECT_EQ(reports.front().query_id, 7);
  EXPECT_EQ(reports.back().query_id, 70);
  EXPECT_THAT(box.TakeReports(), IsEmpty());
}

}  // namespace
}  // namespace cairn::fusion
