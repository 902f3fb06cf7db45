#include "fusion/fusion_options.h"

#include "core/error.h"

namespace cairn::fusion {

void QueryOptions::Validate() const {
  if (!(min_interval_s >= 0.0 && max_pending >= 1 && max_pending <= 6 && timeout_s > 0.0 &&
        min_features >= 0)) {
    throw Error(ErrorCode::kInvalidArgument,
                "query: max_pending must be in [1, 6], times not negative");
  }
}

void FusionOptions::Validate() const {
  for (const double density : {imu_noise.gyro_density, imu_noise.accel_density, imu_noise.gyro_walk,
                               imu_noise.accel_walk}) {
    if (!(density > 0.0)) {
      throw Error(ErrorCode::kInvalidArgument, "imu_noise: every density must be positive");
    }
  }
  if (!(gravity_m_s2 > 9.7 && gravity_m_s2 < 9.9)) {
    throw Error(ErrorCode::kInvalidArgument, "gravity_m_s2 is not that of the Earth's surface");
  }
  if (max_clones < 3 || max_clones > 16 || max_tracks < 1) {
    throw Error(ErrorCode::kInvalidArgument,
                "max_clones must be in [3, 16], max_tracks must be positive");
  }
  if (max_clones + query.max_pending > 18) {
    throw Error(ErrorCode::kInvalidArgument, "max_clones and query.max_pending exceed 18 together");
  }
  if (!(max_imu_gap_s > 0.0 && coasting_after_s > 0.0 && max_slew_m_per_frame > 0.0 &&
        max_slew_rad_per_frame > 0.0 && max_velocity_sigma_m_s > 0.0)) {
    throw Error(ErrorCode::kInvalidArgument, "times and rates must be positive");
  }
  steady.Validate();
  state.Validate();
  standstill.Validate();
  rotation_only.Validate();
  start.Validate();
  dynamic_start.Validate();
  tracks.Validate();
  map.Validate();
  alignment.Validate();
  query.Validate();
}

}  // namespace cairn::fusion
