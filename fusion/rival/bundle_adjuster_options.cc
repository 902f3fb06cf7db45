#include "fusion/rival/bundle_adjuster_options.h"

#include "core/error.h"

namespace cairn::fusion {
namespace {

void Require(bool condition, const char* what) {
  if (!condition) {
    throw Error(ErrorCode::kInvalidArgument, std::string("BundleAdjusterOptions: ") + what);
  }
}

}  // namespace

void BundleAdjusterOptions::Validate() const {
  triangulate.Validate();
  Require(imu_noise.gyro_density > 0.0 && imu_noise.accel_density > 0.0 &&
              imu_noise.gyro_walk > 0.0 && imu_noise.accel_walk > 0.0,
          "imu_noise must be positive");
  Require(gravity_m_s2 > 0.0, "gravity_m_s2 must be positive");
  Require(num_cameras >= 3, "num_cameras must be at least 3");
  Require(num_iterations >= 1, "num_iterations must be positive");
  Require(track_sigma_px > 0.0 && match_sigma_px > 0.0, "pixel noise must be positive");
  Require(huber_sigmas > 0.0 && match_gate_px > 0.0 && track_gate_sigmas > 0.0,
          "gates must be positive");
  Require(min_views >= 2, "min_views must be at least 2");
  Require(max_local_tracks >= 0, "max_local_tracks must not be negative");
  Require(gyro_bias_sigma_rad_s > 0.0 && accel_bias_sigma_m_s2 > 0.0 && gauge_sigma_rad > 0.0 &&
              gauge_sigma_m > 0.0,
          "standard deviations must be positive");
  Require(max_gyro_bias_change_rad_s > 0.0 && max_accel_bias_change_m_s2 > 0.0,
          "bias changes must be positive");
}

}  // namespace cairn::fusion
