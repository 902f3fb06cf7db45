#include "core/log_sink.h"

#include <fmt/format.h>
#include <poll.h>
#include <spdlog/sinks/base_sink.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

namespace cairn {
namespace {

// True if stderr takes PIPE_BUF bytes without waiting, or fails at once.
bool TakesALine() {
  pollfd standard_error{.fd = STDERR_FILENO, .events = POLLOUT, .revents = 0};
  return poll(&standard_error, 1, /*timeout=*/0) > 0;
}

// Text that cannot be written is lost.
void WriteToStderr(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(STDERR_FILENO, text.data(), text.size());
    if (written > 0) {
      text.remove_prefix(static_cast<size_t>(written));
    } else if (written == 0 || errno != EINTR) {
      return;
    }
  }
}

class StderrSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  void SetWaits(bool waits) { waits_ = waits; }

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    if (num_lost_ > 0 && (waits_ || TakesALine())) {
      const std::string note = fmt::format(
          "{} lines of the log were lost, because nobody read them", std::exchange(num_lost_, 0));
      Put({message.logger_name, spdlog::level::warn, spdlog::string_view_t(note)});
    }
    if (waits_ || TakesALine()) {
      Put(message);
    } else {
      ++num_lost_;
    }
  }
  void flush_() override {}

 private:
  void Put(const spdlog::details::log_msg& message) {
    spdlog::memory_buf_t line;
    formatter_->format(message, line);
    if (!waits_ && line.size() > PIPE_BUF) {
      line.resize(PIPE_BUF);
      line[PIPE_BUF - 1] = '\n';
    }
    WriteToStderr({line.data(), line.size()});
  }

  std::atomic<bool> waits_{true};
  int64_t num_lost_ = 0;  // Since the last line.
};

const std::shared_ptr<StderrSink>& Sink() {
  static const auto sink = std::make_shared<StderrSink>();
  return sink;
}

}  // namespace

std::shared_ptr<spdlog::sinks::sink> LogSink() { return Sink(); }

void SetLogWaits(bool waits) { Sink()->SetWaits(waits); }

}  // namespace cairn
