// Standstill: starts the filter at rest, and corrects the filter whenever the device rests again.
#ifndef CAIRN_FUSION_START_STANDSTILL_H_
#define CAIRN_FUSION_START_STANDSTILL_H_

#include <cstdint>
#include <optional>

#include "core/inertial/imu.h"
#include "core/inertial/imu_buffer.h"
#include "core/inertial/imu_propagation.h"
#include "fusion/filter/filter_state.h"
#include "fusion/tracks/track_table.h"

namespace cairn::fusion {

// Length of the recent past that must be quiet at a static start, seconds.
inline constexpr double kStartWindowS = 1.0;
// Largest median motion of the tracks since the device came to rest, pixels.
inline constexpr double kMaxStandstillDisparityPx = 2.5;
// Gate on a standstill, given as a quantile of the standard normal distribution; passes 99.9 % of
// true standstills.
inline constexpr double kStandstillGateQuantile = 3.09;

struct StandstillOptions {
  // Length of the recent past that must be quiet. The start requires kStartWindowS instead.
  double window_s = 0.5;
  // Largest standard deviation of the readings within the window, per axis. The defaults are a few
  // times the noise of a phone's sensor at rest and a tenth of the deviation during a walk. A
  // machine with running motors shakes more while it stands: a quadcopter before take-off has 0.1
  // rad/s and 1.3 m/s^2 (EuRoC V1_01).
  double max_gyro_std_rad_s = 0.02;
  double max_accel_std_m_s2 = 0.15;

  void Validate() const;
};

struct StartState {
  ImuState imu;
  Matrix15d covariance;
};

// Returns true if the readings of [begin_ns, end_ns] are quiet. The buffer must cover that
// interval.
bool IsQuiet(const ImuBuffer& buffer, int64_t begin_ns, int64_t end_ns,
             const StandstillOptions& options);

// Returns the state at `end_ns` of an IMU that has been at rest since `begin_ns`. The IMU is at the
// origin of local with yaw zero. The tilt comes from the mean specific force, the gyroscope bias
// from the mean rate. The covariance contains the correlation of tilt and accelerometer bias. The
// covariance of position and yaw is zero, because they define local. Returns nullopt if the
// readings are not quiet or do not look like rest under gravity.
std::optional<StartState> StaticStart(const ImuBuffer& buffer, int64_t begin_ns, int64_t end_ns,
                                      const ImuNoise& noise, double gravity_m_s2,
                                      const StandstillOptions& options);

// Returns the median distance in pixels between the two observations of each track that both frames
// saw, or nullopt if there are fewer than 10 such tracks.
std::optional<double> MedianDisparity(const TrackTable& tracks, int64_t frame_a, int64_t frame_b);

// Returns the measurement "the velocity is zero and the pose equals that of clone `anchor`".
Measurement StandstillMeasurement(const FilterState& state, int anchor);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_START_STANDSTILL_H_
