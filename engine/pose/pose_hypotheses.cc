#include "engine/pose/pose_hypotheses.h"

#include <algorithm>
#include <utility>

namespace cairn {

std::vector<const PoseHypothesis*> PoseHypotheses::Best(int count) const {
  std::vector<const PoseHypothesis*> best;
  for (const PoseHypothesis& hypothesis : all_) {
    best.push_back(&hypothesis);
  }
  std::stable_sort(best.begin(), best.end(), [](const PoseHypothesis* a, const PoseHypothesis* b) {
    return a->estimate.evidence > b->estimate.evidence;
  });
  best.resize(std::min(best.size(), static_cast<size_t>(count)));
  return best;
}

bool PoseHypotheses::AnyHasEvidence(double min_evidence) const {
  return std::any_of(all_.begin(), all_.end(), [&](const PoseHypothesis& hypothesis) {
    return hypothesis.estimate.evidence >= min_evidence;
  });
}

// The first attempt runs alone. It usually succeeds, and the other attempts then need not look for
// much weaker poses. They follow in rounds of four, which run in parallel if cores are free. The
// rounds do not depend on the number of threads, so the answer does not either.
AttemptCount PoseHypotheses::TryInRounds(int count, bool use_gravity, const QueryBudget& budget,
                                         const std::function<PoseAttempt(int, double)>& attempt) {
  constexpr int kRoundSize = 4;
  AttemptCount total;
  for (int begin = 0, end = 1; begin < count; begin = end, end += kRoundSize) {
    std::vector<PoseAttempt> round(std::min(count, end) - begin);
    const double min_consensus = kMinShareOfBest * best_consensus_;
    ForEachStep(budget.workers, static_cast<int>(round.size()), [&](int i) {
      if (!budget.DeadlinePassed()) {
        round[i] = attempt(begin + i, min_consensus);
      }
    });
    for (PoseAttempt& made : round) {
      total.num_made += made.correspondences != nullptr;
      if (made.estimate) {
        best_consensus_ = std::max(best_consensus_, made.estimate->consensus);
        total.num_ransac_iterations += made.estimate->num_iterations;
        all_.push_back({std::move(*made.estimate), std::move(made.correspondences), use_gravity,
                        std::nullopt});
      }
    }
  }
  return total;
}

}  // namespace cairn
