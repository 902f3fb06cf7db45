// What the stages of a map cost.
#ifndef CAIRN_MAPPING_SESSION_STAGE_CLOCK_H_
#define CAIRN_MAPPING_SESSION_STAGE_CLOCK_H_

#include <sys/resource.h>

#include <chrono>
#include <ctime>
#include <vector>

#include "mapping/session/map_photos.h"

namespace cairn {

inline double PeakMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1e-3 * static_cast<double>(usage.ru_maxrss);
}

inline double ProcessorSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// Measures a stage and adds it to the report.
class StageClock {
 public:
  StageClock(const char* name, std::vector<StageCost>* stages)
      : name_(name),
        stages_(stages),
        start_(std::chrono::steady_clock::now()),
        processor_seconds_(ProcessorSeconds()) {}

  void End(bool from_work) {
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start_;
    stages_->push_back({name_, taken.count(), ProcessorSeconds() - processor_seconds_,
                        PeakMegabytes(), from_work});
  }

 private:
  const char* name_;
  std::vector<StageCost>* stages_;
  std::chrono::steady_clock::time_point start_;
  double processor_seconds_;
};

}  // namespace cairn

#endif  // CAIRN_MAPPING_SESSION_STAGE_CLOCK_H_
