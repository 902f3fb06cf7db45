#include "engine/matching/probe_sequence.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace cairn {
namespace {

// A combination of steps, the last of which is steps[last].
struct Combination {
  int32_t sq_cost;
  uint32_t last;
  uint64_t hash_delta;
};

bool CostsMore(const Combination& a, const Combination& b) { return a.sq_cost > b.sq_cost; }

// A heap of combinations with room for all that FillProbeSequence ever pushes.
class CombinationHeap {
 public:
  void Push(const Combination& combination) {
    heap_[size_++] = combination;
    std::push_heap(heap_.begin(), heap_.begin() + size_, CostsMore);
  }
  Combination Pop() {
    std::pop_heap(heap_.begin(), heap_.begin() + size_, CostsMore);
    return heap_[--size_];
  }

 private:
  std::array<Combination, 2 * kMaxProbes> heap_;
  ptrdiff_t size_ = 0;
};

}  // namespace

// Every combination is reached exactly once, from a cheaper one, by moving its last step to the
// next or by adding the next (Lv et al. 2007, section 4.4).
void FillProbeSequence(std::span<const BorderStep> steps, std::span<uint64_t> deltas) {
  deltas[0] = 0;
  if (deltas.size() == 1) {
    return;
  }
  CombinationHeap heap;
  heap.Push({steps[0].sq_cost, 0, steps[0].hash_delta});
  for (size_t i = 1; i < deltas.size(); ++i) {
    const Combination best = heap.Pop();
    deltas[i] = best.hash_delta;
    const uint32_t next = best.last + 1;
    if (next < steps.size()) {
      const BorderStep& old_step = steps[best.last];
      const BorderStep& new_step = steps[next];
      const Combination added = {best.sq_cost + new_step.sq_cost, next,
                                 best.hash_delta + new_step.hash_delta};
      heap.Push(added);
      heap.Push({added.sq_cost - old_step.sq_cost, next, added.hash_delta - old_step.hash_delta});
    }
  }
}

}  // namespace cairn
