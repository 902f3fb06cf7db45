// Standing still: how the filter starts, and what it learns whenever it happens again.
#ifndef CAIRN_FUSION_START_STANDSTILL_H_
#define CAIRN_FUSION_START_STANDSTILL_H_

#include <cstdint>
#include <optional>

#include "fusion/filter/filter_state.h"
#include "fusion/filter/imu.h"
#include "fusion/filter/imu_buffer.h"
#include "fusion/filter/imu_propagation.h"
#include "fusion/tracks/track_table.h"

namespace cairn::fusion {

struct StandstillOptions {
  double window_s = 0.5;  // The recent past that must be quiet; the start asks for start_window_s.
  double start_window_s = 1.0;
  // Largest standard deviation of the readings within the window, per axis: a few times the noise
  // of a phone's sensor at rest, a tenth of that of a walk. A machine whose motors run shakes more
  // while it stands: a quadcopter before take-off by 0.1 rad/s and 1.3 m/s^2 (EuRoC V1_01).
  double max_gyro_std_rad_s = 0.02;
  double max_accel_std_m_s2 = 0.15;
  // Largest median motion of tracks since the device came to rest; and how many tracks it takes.
  double max_disparity_px = 2.5;
  int min_tracks = 10;
  // What "still" means to the filter, standard deviations per axis.
  double velocity_sigma_m_s = 0.01;
  double position_sigma_m = 0.002;
  double rotation_sigma_rad = 0.001;
  double gate_quantile = 3.09;  // Passes 99.9 % of true standstills.

  void Validate() const;
};

// What is not known at a static start, as standard deviations.
struct StartPrior {
  double gyro_bias_sigma_rad_s = 0.005;  // Beyond what the mean reading says; a slow turn, say.
  double accel_bias_sigma_m_s2 = 0.1;
  double velocity_sigma_m_s = 0.02;

  void Validate() const;
};

struct StartState {
  ImuState imu;
  Matrix15d covariance;
};

// True if the readings of [begin_ns, end_ns], which the buffer must cover, are quiet.
bool IsQuiet(const ImuBuffer& buffer, int64_t begin_ns, int64_t end_ns,
             const StandstillOptions& options);

// The state at `end_ns` of an imu at rest since `begin_ns`, at the origin of local with yaw zero:
// tilt from the mean specific force, gyroscope bias from the mean rate. The covariance holds how
// tilt and accelerometer bias stand for each other; that of position and yaw is zero, as they
// define local. Nothing if the readings are not quiet or are not those of something at rest under
// gravity.
std::optional<StartState> StaticStart(const ImuBuffer& buffer, int64_t begin_ns, int64_t end_ns,
                                      const ImuNoise& noise, double gravity_m_s2,
                                      const StartPrior& prior, const StandstillOptions& options);

// Median distance in pixels between the sights that tracks have in two frames; nothing with fewer
// than options.min_tracks of them.
std::optional<double> MedianDisparity(const TrackTable& tracks, int64_t frame_a, int64_t frame_b,
                                      const StandstillOptions& options);

// "The velocity is zero and the pose is that of clone `anchor`."
Measurement StandstillMeasurement(const FilterState& state, int anchor,
                                  const StandstillOptions& options);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_START_STANDSTILL_H_
