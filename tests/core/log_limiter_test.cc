#include "core/log_limiter.h"

#include <gtest/gtest.h>

#include <chrono>

namespace cairn {
namespace {

using std::chrono::milliseconds;

TEST(LogLimiter, LetsAFewThroughAndThenOneASecond) {
  LogLimiter limiter;
  const LogLimiter::TimePoint start{};
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(limiter.Admit(start), 0);
  }
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(limiter.Admit(start + milliseconds(i / 2)), std::nullopt);
  }
  EXPECT_EQ(limiter.Admit(start + milliseconds(1001)), 1000);
  EXPECT_EQ(limiter.Admit(start + milliseconds(1002)), std::nullopt);
  EXPECT_EQ(limiter.Admit(start + milliseconds(2003)), 1);
}

TEST(LogLimiter, ARestGivesNoMoreThanTheFirstMessages) {
  LogLimiter limiter;
  const LogLimiter::TimePoint start{};
  limiter.Admit(start);
  int num_logged = 0;
  for (int i = 0; i < 100; ++i) {
    num_logged += limiter.Admit(start + std::chrono::hours(1)).has_value();
  }
  EXPECT_EQ(num_logged, 10);
}

}  // namespace
}  // namespace cairn
