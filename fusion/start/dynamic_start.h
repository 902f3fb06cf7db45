// A start in motion: velocity, gravity and biases from a second of inertial samples and tracks.
#ifndef CAIRN_FUSION_START_DYNAMIC_START_H_
#define CAIRN_FUSION_START_DYNAMIC_START_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>

#include "core/camera.h"
#include "fusion/filter/filter_state.h"
#include "fusion/filter/imu.h"
#include "fusion/filter/imu_buffer.h"
#include "fusion/start/standstill.h"
#include "fusion/tracks/track_table.h"
#include "fusion/tracks/track_update.h"

namespace cairn::fusion {

struct DynamicStartOptions {
  bool enabled = true;
  double window_s = 1.2;  // Of samples and frames; longer windows see more of the biases.
  int max_frames = 12;    // Of the window, evenly spaced; at most kMaxClones.
  int min_frames = 6;
  int min_tracks = 20;
  // Prior standard deviations: nothing is known of the biases but what sensors usually have.
  double gyro_bias_sigma_rad_s = 0.02;
  double accel_bias_sigma_m_s2 = 0.1;
  // What the start must have reached to be believed.
  double max_tilt_sigma_rad = 0.05;
  double max_velocity_sigma_m_s = 0.15;
  double min_inlier_fraction = 0.7;  // Tracks that agree with it.

  void Validate() const;
};

// A frame of the window.
struct StartFrame {
  int64_t frame_id = 0;
  int64_t timestamp_ns = 0;  // Of the imu's clock.
};

// Everything the start is made of. `frames` by time, covered by `imu`; their sights are in
// `tracks`.
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

// Velocity and gravity in the frame of the imu at the first frame, such that the rays of every
// track meet: linear in both and in the points, with the size of gravity given (Dong-Si and
// Mourikis 2012). Nothing if the motion does not determine them.
struct LinearStart {
  Eigen::Vector3d velocity_in_imu;
  Eigen::Vector3d gravity_in_imu;
};
std::optional<LinearStart> SolveLinearStart(const DynamicStartInput& input,
                                            const Eigen::Vector3d& gyro_bias,
                                            const DynamicStartOptions& options);

// The state at the last frame, at the origin of local with yaw zero, with its covariance: the
// linear solution, refined by one iterated update of a filter over the window. Nothing if the
// tracks do not bear it out or leave it too uncertain.
std::optional<StartState> DynamicStart(const DynamicStartInput& input,
                                       const DynamicStartOptions& options);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_START_DYNAMIC_START_H_
