// The paper's integer program for landmark selection, solved by Lagrangian relaxation (section
// "Structure Summarization"; Dymczyk et al. 2015).
#ifndef CAIRN_INGEST_TILES_LANDMARK_COVERAGE_H_
#define CAIRN_INGEST_TILES_LANDMARK_COVERAGE_H_

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "ingest/tiles/landmark_selection.h"

namespace cairn {

// maximize   sum_i q_i x_i - lambda sum_k zeta_k
// subject to sum_{i seen by k} x_i + zeta_k >= min(b, landmarks that k sees)  for each keyframe k,
//            sum_i c_i x_i <= budget,  x binary,  zeta >= 0
//
// with q the number of observations, b = options.min_landmarks_per_keyframe and lambda =
// options.missing_landmark_cost. (The paper minimizes q'x, which has the sign wrong for a score,
// and asks for an equal number of landmarks, which poor tiles do not have.) The cost c_i is 1 and
// the budget options.max_landmarks, or c_i is the landmark's number of descriptors and the budget
// options.max_descriptors if there is no limit on landmarks.
struct CoverageSolution {
  std::vector<uint32_t> selection;  // Ascending.
  double objective = 0.0;           // Of the selection.
  // No selection has a larger objective; what the relaxation proves.
  double upper_bound = 0.0;
  int64_t num_missing = 0;  // Sum of zeta.

  // Share of the upper bound that may be missing; 0 proves that the selection is optimal.
  double Gap() const {
    return upper_bound > objective
               ? (upper_bound - objective) / std::max(1.0, std::abs(upper_bound))
               : 0.0;
  }
};

// Landmarks with fewer than options.min_observations are left out. Each of at most
// options.max_iterations rounds takes time linear in landmarks and observations; stops earlier when
// the gap is closed to 1e-4 of the bound. Deterministic.
CoverageSolution SolveCoverage(const VisibilityGraph& graph,
                               const std::vector<int>& num_descriptors,
                               const LandmarkSelectionOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_LANDMARK_COVERAGE_H_
