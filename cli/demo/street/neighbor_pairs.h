// Selects the image pairs that are worth matching, from their poses alone.
#ifndef CAIRN_CLI_DEMO_STREET_NEIGHBOR_PAIRS_H_
#define CAIRN_CLI_DEMO_STREET_NEIGHBOR_PAIRS_H_

#include <utility>
#include <vector>

#include "cli/demo/street/posed_features.h"

namespace cairn {

// Neighbors that each image chooses. Other images may add more.
inline constexpr int kMaxNeighbors = 40;

// Returns the pairs (a, b) with a < b, ascending, each once. World units must be meters. Time is
// linear in the number of images if a bounded number of them is within 30 m of each other.
std::vector<std::pair<int, int>> FindNeighborPairs(const std::vector<PosedFeatures>& images,
                                                   int max_neighbors = kMaxNeighbors);

}  // namespace cairn

#endif  // CAIRN_CLI_DEMO_STREET_NEIGHBOR_PAIRS_H_
