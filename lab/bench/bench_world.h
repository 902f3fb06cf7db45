// A map of the paper's size and queries against it, made without photos: the workload of
// `cairn-lab bench`.
#ifndef CAIRN_LAB_BENCH_BENCH_WORLD_H_
#define CAIRN_LAB_BENCH_BENCH_WORLD_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "eval/eval_query.h"

namespace cairn {

struct BenchWorldOptions {
  int num_tiles = 4;                 // 1, 2 or 4, around the crossing where all queries stand.
  int landmarks_per_tile = 200'000;  // Paper: n.
  int keyframes_per_tile = 1000;
  int num_keypoints = 1000;  // Of a query.
  // Keypoints whose landmark is in the map; the others look like the map but are not in it. A
  // quarter is what photos of a mapped street have.
  double mapped_fraction = 0.25;
  int num_queries = 20;
  uint64_t seed = 1;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

// Writes the map to `map_path`, which must not exist, and returns queries with their true poses and
// noisy priors (10 m, 1 degree). Streets every 50 m with landmarks on the facades, 2.5 descriptors
// a landmark; every query stands within metres of the tiles' common corner, so that its search
// touches all of them. `progress` (may be empty) gets tiles done and total. Deterministic by seed.
std::vector<EvalQuery> BuildBenchWorld(const BenchWorldOptions& options,
                                       const std::string& map_path,
                                       const std::function<void(int, int)>& progress);

}  // namespace cairn

#endif  // CAIRN_LAB_BENCH_BENCH_WORLD_H_
