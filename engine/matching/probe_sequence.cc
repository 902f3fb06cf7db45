#include "engine/matching/probe_sequence.h"

#include <array>
#include <cstddef>
#include <utility>

namespace cairn {
namespace {

// A combination of steps, the last of which is steps[last].
struct Combination {
  int32_t sq_cost;
  uint32_t last;
  Probe probe;
};

// Combinations not yet taken. Sequences are short: a scan for the cheapest beats a heap.
class Frontier {
 public:
  void Push(const Combination& combination) { combinations_[size_++] = combination; }
  Combination PopCheapest() {
    size_t cheapest = 0;
    for (size_t i = 1; i < size_; ++i) {
      cheapest = combinations_[i].sq_cost < combinations_[cheapest].sq_cost ? i : cheapest;
    }
    return std::exchange(combinations_[cheapest], combinations_[--size_]);
  }

 private:
  std::array<Combination, 2 * kMaxProbes> combinations_;
  size_t size_ = 0;
};

// `combination` with the step `index`, which is not among its own.
Combination Added(const Combination& combination, const BorderStep& step, uint32_t index) {
  return {combination.sq_cost + step.sq_cost,
          index,
          {combination.probe.hash + step.delta.hash,
           combination.probe.crossed_dims | step.delta.crossed_dims}};
}

// `combination` without one of its steps.
Combination Removed(const Combination& combination, const BorderStep& step) {
  return {combination.sq_cost - step.sq_cost,
          combination.last,
          {combination.probe.hash - step.delta.hash,
           combination.probe.crossed_dims & ~step.delta.crossed_dims}};
}

}  // namespace

// Every combination is reached exactly once, from a cheaper one, by moving its last step to the
// next or by adding the next (Lv et al. 2007, section 4.4).
void FillProbeSequence(const Probe& own, std::span<const BorderStep> steps,
                       std::span<Probe> probes) {
  probes[0] = own;
  if (probes.size() == 1) {
    return;
  }
  Frontier frontier;
  frontier.Push(Added({0, 0, own}, steps[0], 0));
  for (size_t i = 1; i < probes.size(); ++i) {
    const Combination best = frontier.PopCheapest();
    probes[i] = best.probe;
    const uint32_t next = best.last + 1;
    if (next < steps.size()) {
      const Combination added = Added(best, steps[next], next);
      frontier.Push(added);
      frontier.Push(Removed(added, steps[best.last]));
    }
  }
}

}  // namespace cairn
