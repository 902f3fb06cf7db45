#include "core/log_sink.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <climits>
#include <string>

#include "core/logging.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;

// Standard error is a pipe, which the test reads.
class LogIntoPipe : public ::testing::Test {
 protected:
  LogIntoPipe() : own_stderr_(dup(STDERR_FILENO)) {
    EXPECT_EQ(pipe(ends_), 0);
    fcntl(ends_[0], F_SETFL, O_NONBLOCK);
    EXPECT_GT(fcntl(ends_[1], F_SETPIPE_SZ, kPipeBytes), 0);
    dup2(ends_[1], STDERR_FILENO);
    SetLogWaits(false);
  }
  ~LogIntoPipe() override {
    SetLogWaits(true);
    dup2(own_stderr_, STDERR_FILENO);
    for (const int fd : {own_stderr_, ends_[0], ends_[1]}) {
      close(fd);
    }
  }
  std::string ReadAll() const {
    std::string text;
    std::array<char, PIPE_BUF> some;
    for (ssize_t n = 0; (n = read(ends_[0], some.data(), some.size())) > 0;) {
      text.append(some.data(), static_cast<size_t>(n));
    }
    return text;
  }

  static constexpr int kPipeBytes = 4 * PIPE_BUF;

  int own_stderr_;
  int ends_[2] = {-1, -1};
};

TEST_F(LogIntoPipe, LeavesOutAndCountsLinesThatNobodyReads) {
  constexpr int kLineBytes = 200, kNumLines = 2 * kPipeBytes / kLineBytes;
  for (int i = 0; i < kNumLines; ++i) {
    LogInfo("{}", std::string(kLineBytes, 'a'));
  }
  const std::string before = ReadAll();
  const auto num_written = std::count(before.begin(), before.end(), '\n');
  EXPECT_GT(num_written, 0);
  EXPECT_EQ(before.back(), '\n');
  LogInfo("next");
  const std::string after = ReadAll();
  EXPECT_THAT(after, HasSubstr(fmt::format("{} lines of the log", kNumLines - num_written)));
  EXPECT_THAT(after, HasSubstr("next\n"));
}

TEST_F(LogIntoPipe, CutsLinesThatAFreePipeMayNotTake) {
  LogInfo("{}", std::string(3 * PIPE_BUF, 'a'));
  const std::string text = ReadAll();
  EXPECT_EQ(text.size(), size_t{PIPE_BUF});
  EXPECT_EQ(text.back(), '\n');
}

}  // namespace
}  // namespace cairn
