// Which neighbours of a cell to look into, nearest first.
#ifndef CAIRN_ENGINE_MATCHING_PROBE_SEQUENCE_H_
#define CAIRN_ENGINE_MATCHING_PROBE_SEQUENCE_H_

#include <cstdint>
#include <span>

namespace cairn {

// A cell to look into.
struct Probe {
  uint64_t hash = 0;
  // Bit i: it lies across the nearer border of dimension i, if a sketch (cell_sketch.h) has that.
  uint32_t crossed_dims = 0;
};

// A step across the nearer border of a cell in one dimension.
struct BorderStep {
  int32_t sq_cost = 0;  // Squared distance to the border.
  Probe delta;          // What the step adds to a probe.
};

inline constexpr int kMaxProbes = 32;

// Fills `probes` with the cells that combinations of steps lead to, by ascending sum of costs: the
// first is the cell itself, `own`. `steps` are sorted by cost, at least log2(probes.size()) of
// them; those beyond the first probes.size() - 1 are never needed. probes.size() is at most
// kMaxProbes.
void FillProbeSequence(const Probe& own, std::span<const BorderStep> steps,
                       std::span<Probe> probes);

}  // namespace cairn

#endif  // CAIRN_ENGINE_MATCHING_PROBE_SEQUENCE_H_
