// Starts the filter in motion: finds velocity, gravity and biases from about a second of inertial
// samples and feature tracks.
#ifndef CAIRN_FUSION_START_DYNAMIC_START_H_
#define CAIRN_FUSION_START_DYNAMIC_START_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>

#include "core/camera.h"
#include "core/inertial/imu.h"
#include "core/inertial/imu_buffer.h"
#include "fusion/filter/filter_state.h"
#include "fusion/start/standstill.h"
#include "fusion/tracks/track_table.h"
#include "fusion/tracks/track_update.h"

namespace cairn::fusion {

// Most frames of the window that a start takes, evenly spaced.
inline constexpr int kMaxStartFrames = 12;
static_assert(kMaxStartFrames <= kMaxClones);

struct DynamicStartOptions {
  bool enabled = true;
  // Length of the window of samples and frames. A longer window tells more about the biases.
  double window_s = 1.2;

  void Validate() const;
};

// One camera frame of the window.
struct StartFrame {
  int64_t frame_id = 0;
  int64_t timestamp_ns = 0;  // In the IMU's clock.
};

// The inputs of the start. `frames` are in order of time, and `imu` covers them. `tracks` holds the
// observations of these frames.
struct DynamicStartInput {
  const ImuBuffer& imu;
  const TrackTable& tracks;
  std::span<const StartFrame> frames;
  const Camera& camera;
  const Rig& rig;
  const ImuNoise& imu_noise;
  double gravity_m_s2;
  const TrackUpdateOptions& track_options;
};

// Velocity and gravity in the frame of the IMU at the first frame, chosen such that the rays of
// every track meet. The problem is linear in velocity, gravity and the points; the magnitude of
// gravity is given (Dong-Si and Mourikis 2012). SolveLinearStart returns nullopt if the motion does
// not determine them.
struct LinearStart {
  Eigen::Vector3d velocity_in_imu;
  Eigen::Vector3d gravity_in_imu;
};
std::optional<LinearStart> SolveLinearStart(const DynamicStartInput& input,
                                            const Eigen::Vector3d& gyro_bias);

// Returns the state at the last frame with its covariance; the IMU is at the origin of local with
// yaw zero. The linear solution is refined by one iterated update of a filter over the window.
// Returns nullopt if the tracks contradict the result or leave it too uncertain.
std::optional<StartState> DynamicStart(const DynamicStartInput& input);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_START_DYNAMIC_START_H_
