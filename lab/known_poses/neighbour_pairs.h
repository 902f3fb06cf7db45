// Which images are worth matching, judged by their poses alone.
#ifndef CAIRN_LAB_KNOWN_POSES_NEIGHBOUR_PAIRS_H_
#define CAIRN_LAB_KNOWN_POSES_NEIGHBOUR_PAIRS_H_

#include <utility>
#include <vector>

#include "lab/known_poses/posed_features.h"

namespace cairn {

struct NeighbourOptions {
  int max_neighbours = 40;      // Chosen per image; it may be chosen by more.
  double min_baseline_m = 0.5;  // Below, nothing can be triangulated.
  double max_baseline_m = 30.0;
  double max_turn_rad = 1.05;  // Between viewing directions: SIFT does not bear more.
  double min_overlap = 0.1;    // Share of one's view that the other sees, 4 to 32 m ahead.

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

// Pairs (a, b), a < b, ascending, each once. World units must be metres. Time is linear in the
// number of images as long as a bounded number of them stands within max_baseline_m of each other.
std::vector<std::pair<int, int>> FindNeighbourPairs(const std::vector<PosedFeatures>& images,
                                                    const NeighbourOptions& options);

}  // namespace cairn

#endif  // CAIRN_LAB_KNOWN_POSES_NEIGHBOUR_PAIRS_H_
