// Which landmarks of a tile are kept (paper, section "Structure Summarization").
#ifndef CAIRN_INGEST_TILES_LANDMARK_SELECTION_H_
#define CAIRN_INGEST_TILES_LANDMARK_SELECTION_H_

#include <cstdint>
#include <memory>
#include <vector>

namespace cairn {

// The bipartite visibility graph of one tile.
struct VisibilityGraph {
  std::vector<double> num_observations;  // Per landmark, over the whole reconstruction.
  std::vector<std::vector<uint32_t>> landmarks_of_keyframe;
  size_t num_landmarks() const { return num_observations.size(); }
};

enum class LandmarkSelectionKind {
  kObservationCount,  // The heuristic: see MakeObservationCountSelector.
  kCoverage,          // The integer program: see landmark_coverage.h.
};

struct LandmarkSelectionOptions {
  LandmarkSelectionKind kind = LandmarkSelectionKind::kObservationCount;
  int64_t max_descriptors = 500'000;  // Budget a tile (paper: 500k).
  int min_observations = 2;

  // All below are for kCoverage only.

  // If positive, the budget is this many landmarks (paper: 200k), however many descriptors they
  // have; max_descriptors is ignored.
  int64_t max_landmarks = 0;
  int min_landmarks_per_keyframe = 200;  // Paper; localizing takes a few dozen matches.
  // Cost of each landmark that a keyframe lacks, in observations. Above the observations of the
  // best landmarks, coverage comes first.
  double missing_landmark_cost = 50.0;
  // Largest number of rounds of the solver; 50 suffice for a bound (docs/figures.md).
  int max_iterations = 100;

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

// Keeps the largest sum of observations that leaves each keyframe enough landmarks, as nearly as
// SolveCoverage can.
std::unique_ptr<LandmarkSelector> MakeCoverageSelector(const LandmarkSelectionOptions& options);

// The one that `options.kind` names.
std::unique_ptr<LandmarkSelector> MakeLandmarkSelector(const LandmarkSelectionOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_LANDMARK_SELECTION_H_
