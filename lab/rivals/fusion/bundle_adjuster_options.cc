#include "lab/rivals/fusion/bundle_adjuster_options.h"

#include "core/require.h"

namespace cairn::fusion {

void BundleAdjusterOptions::Validate() const {
  triangulate.Validate();
  RequireOption(imu_noise.gyro_density > 0.0 && imu_noise.accel_density > 0.0 &&
                    imu_noise.gyro_walk > 0.0 && imu_noise.accel_walk > 0.0,
                "bundle_adjuster.imu_noise must be positive");
  RequireOption(gravity_m_s2 > 0.0, "bundle_adjuster.gravity_m_s2 must be positive");
  RequireOption(num_cameras >= 3, "bundle_adjuster.num_cameras must be at least 3");
  RequireOption(num_iterations >= 1, "bundle_adjuster.num_iterations must be positive");
  RequireOption(track_sigma_px > 0.0 && match_sigma_px > 0.0,
                "bundle_adjuster.track_sigma_px and match_sigma_px must be positive");
  RequireOption(
      huber_sigmas > 0.0 && match_gate_px > 0.0 && track_gate_sigmas > 0.0,
      "bundle_adjuster.huber_sigmas, match_gate_px and track_gate_sigmas must be positive");
  RequireOption(min_views >= 2, "bundle_adjuster.min_views must be at least 2");
  RequireOption(max_local_tracks >= 0, "bundle_adjuster.max_local_tracks must not be negative");
  RequireOption(gyro_bias_sigma_rad_s > 0.0 && accel_bias_sigma_m_s2 > 0.0 &&
                    gauge_sigma_rad > 0.0 && gauge_sigma_m > 0.0,
                "bundle_adjuster: standard deviations of biases and gauge must be positive");
  RequireOption(
      max_gyro_bias_change_rad_s > 0.0 && max_accel_bias_change_m_s2 > 0.0,
      "bundle_adjuster.max_gyro_bias_change_rad_s and max_accel_bias_change_m_s2 must be positive");
}

}  // namespace cairn::fusion
