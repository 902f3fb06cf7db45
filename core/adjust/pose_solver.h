// Chooses how an adjustment solves for the poses after the landmarks are eliminated. Private to
// core/adjust.
#ifndef CAIRN_CORE_ADJUST_POSE_SOLVER_H_
#define CAIRN_CORE_ADJUST_POSE_SOLVER_H_

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

// Returns the solver that takes the least time and memory. It depends on how many images share
// landmarks. Only images that move count, and only landmarks that move and decide.
PoseSolver SolverOfPoses(const Reconstruction& model, const std::vector<LandmarkRole>& roles,
                         const AdjustPriors& priors);

}  // namespace cairn

#endif  // CAIRN_CORE_ADJUST_POSE_SOLVER_H_
