// Builds a map of the paper's size and queries against it, without photos: the workload of
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
  int num_tiles = 4;                 // 1, 2 or 4, around the crossing of all queries.
  int landmarks_per_tile = 200'000;  // n in the paper.
  int keyframes_per_tile = 1000;
  int num_keypoints = 1000;  // Per query.
  // Share of the keypoints whose landmark is in the map. The other keypoints look similar but are
  // not in the map. Photos of a mapped street have a share of about a quarter.
  double mapped_fraction = 0.25;
  int num_queries = 20;
  uint64_t seed = 1;

  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;
};

// Writes the map to `map_path`, which must not exist. Returns queries with their true poses and
// noisy priors (10 m, 1 degree). There is a street every 50 m with landmarks on its facades and 2.5
// descriptors per landmark. Every query is within meters of the tiles' common corner, so that its
// search touches all tiles. `progress` (may be empty) receives the number of finished tiles and the
// total. Deterministic by seed.
std::vector<EvalQuery> BuildBenchWorld(const BenchWorldOptions& options,
                                       const std::string& map_path,
                                       const std::function<void(int, int)>& progress);

}  // namespace cairn

#endif  // CAIRN_LAB_BENCH_BENCH_WORLD_H_
