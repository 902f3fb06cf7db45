// Recordings: inertial samples along a trajectory, simulated or real, under simulated cameras.
#ifndef CAIRN_LAB_RECORDINGS_SIMULATE_RECORDING_H_
#define CAIRN_LAB_RECORDINGS_SIMULATE_RECORDING_H_

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/rigid3.h"
#include "fusion/filter/filter_state.h"
#include "fusion/filter/imu.h"
#include "lab/recordings/recording.h"

namespace cairn::fusion {

// A true pose; `global` is z-up.
struct TruePose {
  int64_t timestamp_ns = 0;
  Rigid3d global_from_imu;
};

struct Trajectory {
  std::string name;
  std::vector<ImuSample> imu;   // By time.
  std::vector<TruePose> poses;  // By time, at the rate of the samples or so.
  // Of the unit at the first pose.
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias = Eigen::Vector3d::Zero();
  double gravity_m_s2 = 9.81;
};

struct RecordingOptions {
  Camera camera = Camera(CameraModel::kPinhole, 640, 480, {460.0, 460.0, 320.0, 240.0});
  Rig rig;  // Its time offset must be 0.
  ImuNoise imu_noise;
  double duration_s = 60.0;  // At most; less if the trajectory is shorter.
  double frame_rate_hz = 10.0;
  int frames_per_query = 5;
  double first_counted_s = 5.0;

  int max_features = 300;  // In a frame.
  double track_sigma_px = 1.0;
  double track_loss = 0.03;  // Probability that a track ends, per frame.
  // Landmarks stand around random poses of the trajectory, as walls do.
  int num_landmarks = 20'000;
  double min_distance_m = 3.0;
  double max_distance_m = 16.0;
  double min_height_m = -1.6;  // Above the pose.
  double max_height_m = 4.0;

  int max_matches = 300;  // In an answer.
  double match_sigma_px = 1.0;
  double map_sigma_m = 0.05;  // Of a landmark in the map, per axis.
  double wrong_match_fraction = 0.0;
  // Standard deviations of the state at the start; position and yaw define local.
  double start_tilt_sigma_rad = 0.01;
  double start_velocity_sigma_m_s = 0.05;
  double start_gyro_bias_sigma_rad_s = 0.002;
  double start_accel_bias_sigma_m_s2 = 0.03;
  uint64_t seed = 1;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

// The state at the first frame as an estimator believes it: off by a draw from the covariance that
// comes with it, whose standard deviations are the `start_*` of the options. Local has its origin
// and heading at this frame. `truth` has pose and velocity in global.
StartState DrawStart(const ImuState& truth, const RecordingOptions& options,
                     std::mt19937_64* random);

// Deterministic by seed. Throws Error(kInvalidArgument) as Validate, and Error(kBadInput) if the
// trajectory has fewer than two frames within its poses and samples.
Recording SimulateRecording(const Trajectory& trajectory, const RecordingOptions& options);

// Fits what a recorded trajectory does not say: the constant biases and the vertical under which
// the samples agree best with the poses, and turns `global`, which motion capture levels to a part
// of a degree only, so that this vertical is its z axis. The rate is held against the poses'
// turning over half a second, the specific force against their change of velocity over a second.
// Throws Error(kBadInput) if samples or poses span less than three seconds.
void FitToSamples(Trajectory* trajectory);

// What motion capture is off by, per axis and pose, as white noise.
struct PoseNoise {
  double position_sigma_m = 0.002;
  // Markers on a small body: errors of some mrad that last for seconds, at 100 poses a second.
  double rotation_sigma_rad = 0.01;
};

// Replaces the poses by those that agree best with both the poses and the samples (a
// Rauch-Tung-Striebel smoother), and the biases by those at the first pose. Where poses are more
// than 20 ms apart, those at the samples between them are added. A camera simulated on poses as
// they were captured would shake against the inertial unit to which it is bolted. The trajectory
// must have been through FitToSamples; poses outside the samples are dropped. Throws
// Error(kBadInput) if fewer than two remain, Error(kInvalidArgument) if a sigma is not positive.
void SmoothPoses(const PoseNoise& pose_noise, const ImuNoise& imu_noise, Trajectory* trajectory);

}  // namespace cairn::fusion

#endif  // CAIRN_LAB_RECORDINGS_SIMULATE_RECORDING_H_
