#include "engine/refinement/refinement_options.h"

#include <cmath>

#include "core/require.h"

namespace cairn {

void RefinementOptions::Validate() const {
  RequireOption(good_evidence >= 0.0 && std::isfinite(good_evidence),
                "refinement.good_evidence must not be negative");
  RequireOption(max_keyframes >= 0 && max_keyframes <= 1000,
                "refinement.max_keyframes must lie in [0, 1000]");
  RequireOption(max_pose_keyframes >= 0 && max_pose_keyframes <= 1000,
                "refinement.max_pose_keyframes must lie in [0, 1000]");
  RequireOption(neighbors_per_keyframe >= 0 && neighbors_per_keyframe <= 1000,
                "refinement.neighbors_per_keyframe must lie in [0, 1000]");
  RequireOption(min_separation_m >= 0.0 && std::isfinite(min_separation_m),
                "refinement.min_separation_m must not be negative");
  RequireOption(min_trusted_evidence >= 0.0 && std::isfinite(min_trusted_evidence),
                "refinement.min_trusted_evidence must not be negative");
  RequireOption(max_gravity_error_sigmas >= 0.0,
                "refinement.max_gravity_error_sigmas must not be negative");
}

}  // namespace cairn
