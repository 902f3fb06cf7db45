// Shows the progress of long work on stderr.
#ifndef CAIRN_CLI_PROGRESS_H_
#define CAIRN_CLI_PROGRESS_H_

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace cairn {

enum class ProgressMode {
  kAuto,   // A bar if stderr is a terminal, else plain lines.
  kBar,    // One line, redrawn in place, with the time left once ten seconds tell it.
  kPlain,  // Lines at the start and end of each phase and every ten seconds in between, likewise.
  // One JSON object per line: {"phase": "tiles", "done": 3, "total": 12}, with "secondsLeft" once
  // ten seconds tell it.
  kJson,
};

// Shows one phase at a time. Use from one thread.
class Progress {
 public:
  using Clock = std::function<std::chrono::steady_clock::time_point()>;

  explicit Progress(ProgressMode mode, Clock clock = std::chrono::steady_clock::now);
  ~Progress();  // Ends the bar's line.
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // Cheap to call often: at most a few lines appear per second. A new `phase` begins a new line;
  // done == total completes the phase. A total of 0 means "unknown". A name that begins with that
  // of the phase and ": " is of a step within the phase, which goes on after it; a step of less
  // than a second shows nothing.
  void Update(const std::string& phase, int64_t done, int64_t total);

 private:
  // What counts from a start.
  struct Count {
    std::string name;
    std::chrono::steady_clock::time_point start;
    int64_t start_done = 0;  // Those that were done at the start.
    int64_t last_done = 0;
  };

  bool IsStep(const std::string& phase) const;
  void UpdateStep(const std::string& step, int64_t done, int64_t total);
  bool IsTimeToWrite() const;
  void Write(const Count& count, int64_t done, int64_t total);
  // Empty while ten seconds do not tell it.
  std::optional<double> SecondsLeft(const Count& count, int64_t done, int64_t total) const;
  void EndLine();

  ProgressMode mode_;
  const Clock clock_;
  Count phase_, step_;
  bool line_open_ = false;
  bool phase_complete_ = false;
  std::chrono::steady_clock::time_point last_output_;
};

}  // namespace cairn

#endif  // CAIRN_CLI_PROGRESS_H_
