#include "cli/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

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

Progress::Progress(ProgressMode mode, Clock clock) : mode_(mode), clock_(std::move(clock)) {
  if (mode_ == ProgressMode::kAuto) {
    mode_ = isatty(STDERR_FILENO) == 1 ? ProgressMode::kBar : ProgressMode::kPlain;
  }
}

Progress::~Progress() { EndLine(); }

bool Progress::IsStep(const std::string& phase) const {
  return !phase_.name.empty() && phase.starts_with(phase_.name + ": ");
}

bool Progress::IsTimeToWrite() const { return clock_() - last_output_ >= MinInterval(mode_); }

void Progress::Update(const std::string& phase, int64_t done, int64_t total) {
  if (IsStep(phase)) {
    UpdateStep(phase, done, total);
    return;
  }
  const bool new_phase = phase != phase_.name;
  const bool complete = total > 0 && done >= total;
  if (!new_phase && phase_complete_) {
    return;
  }
  step_ = {};
  if (new_phase) {
    EndLine();
    phase_ = {phase, clock_(), done, done};
    phase_complete_ = false;
  }
  if (new_phase || complete || IsTimeToWrite()) {
    Write(phase_, done, total);
  }
  if (complete) {
    phase_complete_ = true;
    EndLine();
  }
}

void Progress::UpdateStep(const std::string& step, int64_t done, int64_t total) {
  if (step != step_.name || done < step_.last_done) {
    step_ = {step, clock_(), done, done};
  }
  step_.last_done = done;
  constexpr std::chrono::seconds kShort(1);
  if (clock_() - step_.start >= kShort && IsTimeToWrite()) {
    Write(step_, done, total);
  }
}

std::optional<double> Progress::SecondsLeft(const Count& count, int64_t done, int64_t total) const {
  constexpr double kLeastSeconds = 10.0;
  const std::chrono::duration<double> taken = clock_() - count.start;
  if (done <= count.start_done || done >= total || taken.count() < kLeastSeconds) {
    return std::nullopt;
  }
  return taken.count() * static_cast<double>(total - done) /
         static_cast<double>(done - count.start_done);
}

void Progress::Write(const Count& count, int64_t done, int64_t total) {
  last_output_ = clock_();
  const std::optional<double> left_s = SecondsLeft(count, done, total);
  switch (mode_) {
    case ProgressMode::kAuto:
    case ProgressMode::kBar:
      fmt::print(stderr, "\r\033[K{:<14} [{}] {}/{}{}", count.name, Bar(done, total), done, total,
                 TimeLeft(left_s));
      std::fflush(stderr);
      line_open_ = true;
      break;
    case ProgressMode::kPlain:
      fmt::print(stderr, "{}: {}/{}{}\n", count.name, done, total, TimeLeft(left_s));
      break;
    case ProgressMode::kJson: {
      nlohmann::ordered_json line = {{"phase", count.name}, {"done", done}, {"total", total}};
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
