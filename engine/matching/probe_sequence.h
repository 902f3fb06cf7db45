// Which neighbours of a cell to look into, nearest first.
#ifndef CAIRN_ENGINE_MATCHING_PROBE_SEQUENCE_H_
#define CAIRN_ENGINE_MATCHING_PROBE_SEQUENCE_H_

#include <cstdint>
#include <span>

namespace cairn {

// A step across the nearer border of a cell in one dimension.
struct BorderStep {
  int32_t sq_cost = 0;      // Squared distance to the border.
  uint64_t hash_delta = 0;  // What the step adds to the cell's hash.
};

inline constexpr int kMaxProbes = 32;

// Fills `deltas` with the hash deltas of the cells that combinations of steps lead to, by ascending
// sum of costs: the first is the cell itself, 0. `steps` are sorted by cost, at least
// log2(deltas.size()) of them; those beyond the first deltas.size() - 1 are never needed.
// deltas.size() is at most kMaxProbes.
void FillProbeSequence(std::span<const BorderStep> steps, std::span<uint64_t> deltas);

}  // namespace cairn

#endif  // CAIRN_ENGINE_MATCHING_PROBE_SEQUENCE_H_
