#include "cli/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace cairn {
namespace {

constexpr int kBarWidth = 32;

std::chrono::milliseconds MinInterval(ProgressMode mode) {
  return std::chrono::milliseconds(mode == ProgressMode::kPlain ? 10'000 : 100);
}

// E.g. ", 40 s left"; empty while it is not known.
std::string TimeLeft(std::optional<double> left_s) {
  if (!left_s) {
    return "";
  }
  return *left_s < 100.0 ? fmt::format(", {:.0f} s left", *left_s)
                         : fmt::format(", {:.0f} min left", *left_s / 60.0);
}

std::string Bar(int64_t done, int64_t total) {
  const int filled =
      total > 0 ? static_cast<int>(std::clamp<int64_t>(done * kBarWidth / total, 0, kBarWidth)) : 0;
  return std::string(filled, '#') + std::string(kBarWidth - filled, '.');
}

}  // namespace

Progress::Progress(ProgressMode mode) : mode_(mode) {
  if (mode_ == ProgressMode::kAuto) {
    mode_ = isatty(STDERR_FILENO) == 1 ? ProgressMode::kBar : ProgressMode::kPlain;
  }
}

Progress::~Progress() { EndLine(); }

void Progress::Update(const std::string& phase, int64_t done, int64_t total) {
  const bool new_phase = phase != phase_;
  const bool complete = total > 0 && done >= total;
  if (!new_phase && phase_complete_) {
    return;
  }
  if (new_phase) {
    EndLine();
    phase_ = phase;
    phase_complete_ = false;
    phase_start_ = std::chrono::steady_clock::now();
    phase_start_done_ = done;
  }
  const auto now = std::chrono::steady_clock::now();
  if (new_phase || complete || now - last_output_ >= MinInterval(mode_)) {
    last_output_ = now;
    Write(done, total);
  }
  if (complete) {
    phase_complete_ = true;
    EndLine();
  }
}

std::optional<double> Progress::SecondsLeft(int64_t done, int64_t total) const {
  constexpr double kLeastSeconds = 10.0;
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - phase_start_;
  if (done <= phase_start_done_ || done >= total || taken.count() < kLeastSeconds) {
    return std::nullopt;
  }
  return taken.count() * static_cast<double>(total - done) /
         static_cast<double>(done - phase_start_done_);
}

void Progress::Write(int64_t done, int64_t total) {
  const std::optional<double> left_s = SecondsLeft(done, total);
  switch (mode_) {
    case ProgressMode::kAuto:
    case ProgressMode::kBar:
      fmt::print(stderr, "\r\033[K{:<14} [{}] {}/{}{}", phase_, Bar(done, total), done, total,
                 TimeLeft(left_s));
      std::fflush(stderr);
      line_open_ = true;
      break;
    case ProgressMode::kPlain:
      fmt::print(stderr, "{}: {}/{}{}\n", phase_, done, total, TimeLeft(left_s));
      break;
    case ProgressMode::kJson: {
      nlohmann::ordered_json line = {{"phase", phase_}, {"done", done}, {"total", total}};
      if (left_s) {
        line["secondsLeft"] = std::round(*left_s);
      }
      fmt::print(stderr, "{}\n", line.dump());
      break;
    }
  }
}

void Progress::EndLine() {
  if (line_open_) {
    std::fputc('\n', stderr);
    line_open_ = false;
  }
}

}  // namespace cairn
