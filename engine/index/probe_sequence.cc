#include "engine/index/probe_sequence.h"

#include <algorithm>
#include <functional>
#include <queue>
#include <tuple>

namespace cairn {
namespace {

// A combination of steps: those of the probe `parent`, and the step `last`, which is longer than
// them.
struct Combination {
  double sq_length = 0.0;
  int parent = 0;
  int last = 0;

  friend bool operator>(const Combination& a, const Combination& b) {
    return std::tie(a.sq_length, a.parent, a.last) > std::tie(b.sq_length, b.parent, b.last);
  }
};

// Returns the mean squared length of the i-th shortest of `num_dims` steps, each uniform in [0, 1]:
// the second moment of an order statistic.
double MeanSqLength(int i, int num_dims) {
  return (i + 1.0) * (i + 2.0) / ((num_dims + 1.0) * (num_dims + 2.0));
}

}  // namespace

// Each combination is reached exactly once, from a shorter one: by adding the next step, or by
// replacing the last step with the next.
ProbeSequence::ProbeSequence(int num_dims, int num_probes) : probes_(1) {
  std::priority_queue<Combination, std::vector<Combination>, std::greater<>> waiting;
  waiting.push({MeanSqLength(0, num_dims), 0, 0});
  while (static_cast<int>(probes_.size()) < num_probes && !waiting.empty()) {
    const Combination next = waiting.top();
    waiting.pop();
    const int probe = static_cast<int>(probes_.size());
    probes_.push_back({static_cast<uint8_t>(next.parent), static_cast<uint8_t>(next.last)});
    num_steps_ = std::max(num_steps_, next.last + 1);
    const int step = next.last + 1;
    if (step < num_dims) {
      const double added = MeanSqLength(step, num_dims);
      waiting.push({next.sq_length + added, probe, step});
      waiting.push({next.sq_length - MeanSqLength(next.last, num_dims) + added, next.parent, step});
    }
  }
}

}  // namespace cairn
