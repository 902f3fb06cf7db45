// Runs the stages of a query.
#ifndef CAIRN_ENGINE_STAGE_RUNNER_H_
#define CAIRN_ENGINE_STAGE_RUNNER_H_

#include <cstddef>

#include "core/seconds_since.h"
#include "engine/query/localize_result.h"
#include "engine/query/query_budget.h"

namespace cairn {

// Runs stages and adds up their times, until a stage returns a reason why there is no answer, or
// the deadline passes. A stage may run several times.
class StageRunner {
 public:
  // Keeps a reference to the budget.
  explicit StageRunner(const QueryBudget& budget) : budget_(budget) {}

  bool is_running() const { return reason_ == NotLocalizedReason::kNone; }
  NotLocalizedReason reason() const { return reason_; }
  // Of the stages; the total stays 0.
  const StageTimes& times() const { return times_; }

  template <typename Work>
  void Run(Stage stage, const Work& work) {
    if (!is_running()) {
      return;
    }
    if (budget_.DeadlinePassed()) {
      reason_ = NotLocalizedReason::kTimeout;
      return;
    }
    const QueryBudget::Clock::time_point start = QueryBudget::Clock::now();
    reason_ = work();
    times_.seconds[static_cast<size_t>(stage)] += SecondsSince(start);
  }

 private:
  const QueryBudget& budget_;
  NotLocalizedReason reason_ = NotLocalizedReason::kNone;
  StageTimes times_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_STAGE_RUNNER_H_
