#include "fusion/estimator/fusion_options.h"

#include "core/require.h"

namespace cairn::fusion {

void QueryOptions::Validate() const {
  RequireOption(min_interval_s >= 0.0, "query.min_interval_s must not be negative");
  RequireWithin("query.max_pending", max_pending, 1, 6);
  RequireOption(timeout_s > 0.0, "query.timeout_s must be positive");
}

void FusionOptions::Validate() const {
  RequireOption(imu_noise.gyro_density > 0.0 && imu_noise.accel_density > 0.0 &&
                    imu_noise.gyro_walk > 0.0 && imu_noise.accel_walk > 0.0,
                "imu_noise must be positive");
  RequireOption(gravity_m_s2 > 9.7 && gravity_m_s2 < 9.9,
                "gravity_m_s2 must be that of the Earth's surface");
  RequireWithin("max_clones", max_clones, 3, 16);
  RequireOption(max_clones + query.max_pending <= 18,
                "max_clones and query.max_pending must not exceed 18 together");
  steady.Validate();
  state.Validate();
  standstill.Validate();
  dynamic_start.Validate();
  tracks.Validate();
  map.Validate();
  query.Validate();
}

}  // namespace cairn::fusion
