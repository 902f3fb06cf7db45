// Limits how often a kind of message is logged.
#ifndef CAIRN_CORE_LOG_LIMITER_H_
#define CAIRN_CORE_LOG_LIMITER_H_

#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>

namespace cairn {

// Lets the first messages of a series through and then one a second, so that clients who cause
// errors cannot fill the disk. Safe to call from any thread.
class LogLimiter {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  // Returns the number of messages that were left out since the last one, if a message may be
  // logged now.
  std::optional<int64_t> Admit(TimePoint now = std::chrono::steady_clock::now()) {
    constexpr double kMaxAtOnce = 10.0;
    constexpr double kPerSecond = 1.0;
    const std::lock_guard lock(mutex_);
    if (last_) {
      allowance_ += kPerSecond * std::chrono::duration<double>(now - *last_).count();
    }
    last_ = now;
    allowance_ = allowance_ < kMaxAtOnce ? allowance_ : kMaxAtOnce;
    if (allowance_ < 1.0) {
      ++num_left_out_;
      return std::nullopt;
    }
    allowance_ -= 1.0;
    const int64_t num_left_out = num_left_out_;
    num_left_out_ = 0;
    return num_left_out;
  }

 private:
  std::mutex mutex_;
  std::optional<TimePoint> last_;
  double allowance_ = 10.0;  // Messages that may be logged now.
  int64_t num_left_out_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_CORE_LOG_LIMITER_H_
