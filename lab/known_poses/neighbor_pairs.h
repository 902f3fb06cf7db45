// Selects the image pairs that are worth matching, from their poses alone.
#ifndef CAIRN_LAB_KNOWN_POSES_NEIGHBOUR_PAIRS_H_
#define CAIRN_LAB_KNOWN_POSES_NEIGHBOUR_PAIRS_H_

#include <utility>
#include <vector>

#include "lab/known_poses/posed_features.h"

namespace cairn {

struct NeighborOptions {
  int max_neighbors = 40;       // Chosen by each image. Other images may add more.
  double min_baseline_m = 0.5;  // A shorter baseline cannot triangulate.
  double max_baseline_m = 30.0;
  double max_turn_rad = 1.05;  // Between viewing directions; SIFT tolerates no more.
  double min_overlap = 0.1;    // Share of one image's view, 4 to 32 m ahead, that the other sees.

  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;
};

// Returns the pairs (a, b) with a < b, ascending, each once. World units must be meters. Time is
// linear in the number of images if a bounded number of them is within max_baseline_m of each
// other.
std::vector<std::pair<int, int>> FindNeighborPairs(const std::vector<PosedFeatures>& images,
                                                   const NeighborOptions& options);

}  // namespace cairn

#endif  // CAIRN_LAB_KNOWN_POSES_NEIGHBOUR_PAIRS_H_
