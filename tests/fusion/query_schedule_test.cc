#include "fusion/estimator/query_schedule.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cairn::fusion {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr int64_t kSecondNs = 1'000'000'000;

TEST(QuerySchedule, AsksAtIntervals) {
  QuerySchedule queries({.min_interval_s = 1.0});
  EXPECT_TRUE(queries.IsDue(0));
  queries.Ask(1, 5 * kSecondNs);
  EXPECT_FALSE(queries.IsDue(6 * kSecondNs - 1));
  EXPECT_TRUE(queries.IsDue(6 * kSecondNs));
}

TEST(QuerySchedule, AsksNoMoreThanMayBePending) {
  QuerySchedule queries({.min_interval_s = 0.0, .max_pending = 2});
  const int64_t first = queries.Ask(1, 1);
  EXPECT_TRUE(queries.IsDue(2));
  queries.Ask(2, 2);
  EXPECT_FALSE(queries.IsDue(3));
  queries.TakeFrame(first);
  EXPECT_TRUE(queries.IsDue(3));
}

TEST(QuerySchedule, AnAnswerFindsItsFrameOnce) {
  QuerySchedule queries({});
  const int64_t query_id = queries.Ask(7, kSecondNs);
  EXPECT_TRUE(queries.HasFrame(7));
  EXPECT_EQ(queries.TakeFrame(query_id + 1), std::nullopt);
  EXPECT_EQ(queries.TakeFrame(query_id), 7);
  EXPECT_EQ(queries.TakeFrame(query_id), std::nullopt);
  EXPECT_FALSE(queries.HasFrame(7));
  EXPECT_FALSE(queries.HasExpired(query_id));
}

TEST(QuerySchedule, QueriesExpireAndAreRemembered) {
  QuerySchedule queries({.timeout_s = 2.0});
  const int64_t old_query = queries.Ask(1, 0);
  const int64_t new_query = queries.Ask(2, kSecondNs);
  EXPECT_THAT(queries.Expire(2 * kSecondNs), IsEmpty());
  EXPECT_THAT(queries.Expire(2 * kSecondNs + 1), ElementsAre(1));
  EXPECT_EQ(queries.TakeFrame(old_query), std::nullopt);
  EXPECT_TRUE(queries.HasExpired(old_query));
  EXPECT_FALSE(queries.HasExpired(new_query));
  EXPECT_EQ(queries.TakeFrame(new_query), 2);
}

TEST(QuerySchedule, ARestartForgetsWhatIsPendingButNoId) {
  QuerySchedule queries({.min_interval_s = 1.0, .timeout_s = 2.0});
  const int64_t expired = queries.Ask(1, 0);
  queries.Expire(5 * kSecondNs);
  const int64_t pending = queries.Ask(2, 5 * kSecondNs);
  queries.Restart();
  EXPECT_FALSE(queries.HasFrame(2));
  EXPECT_EQ(queries.TakeFrame(pending), std::nullopt);
  EXPECT_FALSE(queries.HasExpired(pending));
  EXPECT_TRUE(queries.HasExpired(expired));
  EXPECT_TRUE(queries.IsDue(0));  // The clock may have been set back.
  EXPECT_GT(queries.Ask(3, 0), pending);
}

}  // namespace
}  // namespace cairn::fusion
