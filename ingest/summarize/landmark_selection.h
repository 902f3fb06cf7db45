// Which landmarks of a tile are kept (paper, section "Structure Summarization").
#ifndef CAIRN_INGEST_SUMMARIZE_LANDMARK_SELECTION_H_
#define CAIRN_INGEST_SUMMARIZE_LANDMARK_SELECTION_H_

#include <cstdint>
#include <memory>
#include <vector>

namespace cairn {

// The bipartite visibility graph of one tile.
struct VisibilityGraph {
  std::vector<int> num_observations;  // Per landmark, over the whole reconstruction.
  std::vector<std::vector<uint32_t>> landmarks_of_keyframe;
  size_t num_landmarks() const { return num_observations.size(); }
};

struct LandmarkSelectionOptions {
  int64_t max_descriptors = 500'000;  // Budget a tile (paper: 500k).
  int min_observations = 2;

  void Validate() const;
};

// Interface of all selectors. Implementations are stateless and thread-safe.
class LandmarkSelector {
 public:
  virtual ~LandmarkSelector() = default;
  // Ascending indices of the landmarks to keep. `num_descriptors[i]` is what landmark i will cost.
  virtual std::vector<uint32_t> Select(const VisibilityGraph& graph,
                                       const std::vector<int>& num_descriptors) const = 0;
};

// The paper's heuristic: each keyframe gets an equal share of the budget and keeps its most
// observed landmarks until the share is spent; what is left over goes to the most observed of the
// rest.
std::unique_ptr<LandmarkSelector> MakeObservationCountSelector(
    const LandmarkSelectionOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_SUMMARIZE_LANDMARK_SELECTION_H_
