// The threads and the time that a query may use.
#ifndef CAIRN_ENGINE_QUERY_QUERY_BUDGET_H_
#define CAIRN_ENGINE_QUERY_QUERY_BUDGET_H_

#include <chrono>
#include <optional>

#include "core/shared_workers.h"
#include "core/stop_function.h"

namespace cairn {

struct QueryBudget {
  using Clock = std::chrono::steady_clock;

  SharedWorkers* workers = nullptr;           // If null, only the calling thread works.
  std::optional<Clock::time_point> deadline;  // If empty, time is unlimited.

  bool DeadlinePassed() const { return deadline && Clock::now() >= *deadline; }

  // Returns a function that returns true once this share of the time from now to the deadline has
  // passed; without a deadline, never.
  StopFunction StopAfter(double share) const {
    if (!deadline) {
      return {};
    }
    const Clock::time_point now = Clock::now();
    const std::chrono::duration<double> left = *deadline - now;
    const Clock::time_point end = now + std::chrono::duration_cast<Clock::duration>(share * left);
    return [end] { return Clock::now() >= end; };
  }
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_QUERY_QUERY_BUDGET_H_
