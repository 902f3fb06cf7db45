#include "engine/pose/pose_options.h"

#include <algorithm>

#include "core/require.h"

namespace cairn {

void PoseOptions::Validate() const {
  RequireOption(max_error_px > 0.0 && max_error_px <= 1000.0,
                "pose.max_error_px must lie in (0, 1000]");
  RequireOption(keypoint_sigma_px > 0.0 && keypoint_sigma_px <= 1000.0,
                "pose.keypoint_sigma_px must lie in (0, 1000]");
  RequireOption(min_iterations >= 1, "pose.min_iterations must be at least 1");
  RequireOption(max_iterations >= min_iterations,
                "pose.max_iterations must be at least min_iterations");
  RequireOption(distance_weight >= 0.0 && distance_weight <= 1000.0,
                "pose.distance_weight must lie in [0, 1000]");
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
