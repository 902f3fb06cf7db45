#include "engine/pose/pose_options.h"

#include <algorithm>

#include "core/require.h"

namespace cairn {

void ConsensusOptions::Validate() const {
  RequireOption(max_rejected_share > 0.0 && max_rejected_share < 1.0,
                "pose.consensus.max_rejected_share must lie in (0, 1)");
}

void PoseOptions::Validate() const {
  consensus.Validate();
  evidence.Validate();
  RequireOption(max_error_px > 0.0 && max_error_px <= 1000.0,
                "pose.max_error_px must lie in (0, 1000]");
  RequireOption(keypoint_sigma_px > 0.0 && keypoint_sigma_px <= 1000.0,
                "pose.keypoint_sigma_px must lie in (0, 1000]");
  RequireOption(min_iterations >= 1, "pose.min_iterations must be at least 1");
  RequireOption(max_iterations >= min_iterations,
                "pose.max_iterations must be at least min_iterations");
  RequireOption(success_probability > 0.0 && success_probability < 1.0,
                "pose.success_probability must lie in (0, 1)");
  RequireOption(distance_weight >= 0.0 && distance_weight <= 1000.0,
                "pose.distance_weight must lie in [0, 1000]");
  RequireOption(num_local_optimizations >= 1, "pose.num_local_optimizations must be at least 1");
  RequireOption(min_inliers >= 4, "pose.min_inliers must be at least 4");
  RequireOption(gravity_sigma_rad > 0.0 && gravity_sigma_rad <= 0.5,
                "pose.gravity_sigma_rad must lie in (0, 0.5]");
}

double PoseOptions::MaxErrorPx(double focal_px) const {
  constexpr double kReferenceFocalPx = 500.0;
  constexpr double kMinErrorPx = 2.0;
  return std::max(kMinErrorPx, max_error_px * focal_px / kReferenceFocalPx);
}

}  // namespace cairn
