// The order in which the neighbors of a cell are searched, nearest first.
#ifndef CAIRN_ENGINE_INDEX_PROBE_SEQUENCE_H_
#define CAIRN_ENGINE_INDEX_PROBE_SEQUENCE_H_

#include <cstdint>
#include <span>
#include <vector>

namespace cairn {

inline constexpr int kMaxProbes = 128;

// Combinations of steps across the nearest borders of a cell, ordered by the distance to the cell
// they lead to. The distance assumes the mean step lengths of a random point (Lv et al. 2007,
// section 4.5). Sharing one order among all queries saves computing an order for each query; the
// same recall then takes one more probe in twenty. Immutable; safe to use from any thread.
class ProbeSequence {
 public:
  // For a grid with `num_dims` >= 1 dimensions; num_probes is in [1, kMaxProbes]. There are fewer
  // probes if there are fewer combinations.
  ProbeSequence(int num_dims, int num_probes);

  int size() const { return static_cast<int>(probes_.size()); }
  // Number of shortest steps that the sequence uses.
  int num_steps() const { return num_steps_; }

  // Writes size() hashes. The first is `own`, the hash of the cell itself; the others are the
  // hashes of the neighbors. steps[i] is the contribution of the i-th shortest step to a hash.
  void Fill(uint32_t own, std::span<const uint32_t> steps, uint32_t* hashes) const {
    hashes[0] = own;
    for (size_t i = 1; i < probes_.size(); ++i) {
      hashes[i] = hashes[probes_[i].parent] + steps[probes_[i].step];
    }
  }

 private:
  // Extends an earlier probe by one step.
  struct Probe {
    uint8_t parent = 0;
    uint8_t step = 0;
  };

  std::vector<Probe> probes_;
  int num_steps_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_PROBE_SEQUENCE_H_
