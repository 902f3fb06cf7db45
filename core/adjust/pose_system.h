// How the system of the poses is solved, which is what an adjustment comes down to once the
// landmarks are eliminated. Private to core/adjust.
#ifndef CAIRN_CORE_ADJUST_POSE_SYSTEM_H_
#define CAIRN_CORE_ADJUST_POSE_SYSTEM_H_

#include <vector>

#include "core/adjust/adjust.h"
#include "core/adjust/landmark_roles.h"
#include "core/scene/reconstruction.h"

namespace cairn {

enum class PoseSolver {
  kDense,       // Factored as a full matrix.
  kSparse,      // Factored after an order is found that fills little of it.
  kIterations,  // Conjugate gradients.
};

// Returns what solves the system in the least time and memory. It depends on how many images share
// landmarks with one another, of those that move and that decide.
PoseSolver SolverOfPoses(const Reconstruction& model, const std::vector<LandmarkRole>& roles,
                         const AdjustPriors& priors);

}  // namespace cairn

#endif  // CAIRN_CORE_ADJUST_POSE_SYSTEM_H_
