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
  uint64_t hash_delta;
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

}  // namespace

// Every combination is reached exactly once, from a cheaper one, by moving its last step to the
// next or by adding the next (Lv et al. 2007, section 4.4).
void FillProbeSequence(std::span<const BorderStep> steps, std::span<uint64_t> deltas) {
  deltas[0] = 0;
  if (deltas.size() == 1) {
    return;
  }
  Frontier frontier;
  frontier.Push({steps[0].sq_cost, 0, steps[0].hash_delta});
  for (size_t i = 1; i < deltas.size(); ++i) {
    const Combination best = frontier.PopCheapest();
    deltas[i] = best.hash_delta;
    const uint32_t next = best.last + 1;
    if (next < steps.size()) {
      const BorderStep& old_step = steps[best.last];
      const BorderStep& new_step = steps[next];
      const Combination added = {best.sq_cost + new_step.sq_cost, next,
                                 best.hash_delta + new_step.hash_delta};
      frontier.Push(added);
      frontier.Push(
          {added.sq_cost - old_step.sq_cost, next, added.hash_delta - old_step.hash_delta});
    }
  }
}

}  // namespace cairn
