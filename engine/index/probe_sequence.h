// Which neighbours of a cell to look into, nearest first.
#ifndef CAIRN_ENGINE_INDEX_PROBE_SEQUENCE_H_
#define CAIRN_ENGINE_INDEX_PROBE_SEQUENCE_H_

#include <cstdint>
#include <span>
#include <vector>

namespace cairn {

inline constexpr int kMaxProbes = 128;

// Combinations of steps across the nearest borders of a cell, by ascending distance to the cells
// that they lead to, if the steps are as long as those of a random point are in the mean (Lv et al.
// 2007, section 4.5). One order for all queries spares the search for each query's own; it finds
// the same with one probe in twenty more. Immutable; safe to use from any thread.
class ProbeSequence {
 public:
  // Of a grid with `num_dims` >= 1 dimensions; num_probes is in [1, kMaxProbes]. There are fewer
  // where there are not so many combinations.
  ProbeSequence(int num_dims, int num_probes);

  int size() const { return static_cast<int>(probes_.size()); }
  // How many of the shortest steps it uses.
  int num_steps() const { return num_steps_; }

  // Writes size() hashes: first `own`, that of the cell itself, then those that combinations of
  // steps change it to. steps[i] is what the i-th shortest step adds to a hash.
  void Fill(uint32_t own, std::span<const uint32_t> steps, uint32_t* hashes) const {
    hashes[0] = own;
    for (size_t i = 1; i < probes_.size(); ++i) {
      hashes[i] = hashes[probes_[i].parent] + steps[probes_[i].step];
    }
  }

 private:
  // What an earlier one becomes by one more step.
  struct Probe {
    uint8_t parent = 0;
    uint8_t step = 0;
  };

  std::vector<Probe> probes_;
  int num_steps_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_PROBE_SEQUENCE_H_
