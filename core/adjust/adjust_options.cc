#include <cmath>

#include "core/adjust/adjust.h"
#include "core/require.h"

namespace cairn {

void AdjustOptions::Validate() const {
  RequireOption(loss_scale_sigmas > 0.0, "adjust.loss_scale_sigmas must be positive");
  RequireOption(position_loss_scale_sigmas > 0.0,
                "adjust.position_loss_scale_sigmas must be positive");
  RequireOption(distortion_sigma > 0.0, "adjust.distortion_sigma must be positive");
  RequireOption(principal_point_loss_scale > 0.0,
                "adjust.principal_point_loss_scale must be positive");
  RequireOption(max_iterations >= 1, "adjust.max_iterations must be at least 1");
  RequireOption(min_relative_change >= 0.0 && min_relative_change < 1.0,
                "adjust.min_relative_change must be in [0, 1)");
  RequireOption(max_error_sigmas > 0.0, "adjust.max_error_sigmas must be positive");
  RequireOption(max_rounds >= 1, "adjust.max_rounds must be at least 1");
  RequireOption(max_observations_of_all >= 0,
                "adjust.max_observations_of_all must not be negative");
  RequireOption(min_ray_angle_rad >= 0.0 && std::isfinite(min_ray_angle_rad),
                "adjust.min_ray_angle_rad must be finite and not negative");
  RequireOption(num_threads >= 1, "adjust.num_threads must be at least 1");
}

}  // namespace cairn
