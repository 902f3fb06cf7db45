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
  StageRunner(const QueryBudget& budget, LocalizeResult* result)
      : budget_(budget), result_(*result) {
    result_.reason = NotLocalizedReason::kNone;
  }

  bool is_running() const { return result_.reason == NotLocalizedReason::kNone; }

  template <typename Work>
  void Run(Stage stage, const Work& work) {
    if (!is_running()) {
      return;
    }
    if (budget_.DeadlinePassed()) {
      result_.reason = NotLocalizedReason::kTimeout;
      return;
    }
    const QueryBudget::Clock::time_point start = QueryBudget::Clock::now();
    result_.reason = work();
    result_.times.seconds[static_cast<size_t>(stage)] += SecondsSince(start);
  }

 private:
  const QueryBudget& budget_;
  LocalizeResult& result_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_STAGE_RUNNER_H_
