// Makes recordings: inertial samples along a simulated or real trajectory, seen by simulated
// cameras.
#ifndef CAIRN_EVAL_RECORDINGS_SIMULATE_RECORDING_H_
#define CAIRN_EVAL_RECORDINGS_SIMULATE_RECORDING_H_

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/inertial/imu.h"
#include "core/rigid3.h"
#include "eval/recordings/recording.h"
#include "fusion/filter/filter_state.h"

namespace cairn::fusion {

// A true pose. `global` is z-up.
struct TruePose {
  int64_t timestamp_ns = 0;
  Rigid3d global_from_imu;
};

struct Trajectory {
  std::string name;
  std::vector<ImuSample> imu;   // Ordered by time.
  std::vector<TruePose> poses;  // Ordered by time, at about the rate of the samples.
  // Biases of the IMU at the first pose.
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_bias = Eigen::Vector3d::Zero();
  double gravity_m_s2 = 9.81;
};

struct RecordingOptions {
  Camera camera = Camera(CameraModel::kPinhole, 640, 480, {460.0, 460.0, 320.0, 240.0});
  Rig rig;  // The time offset must be 0.
  ImuNoise imu_noise;
  double duration_s = 60.0;  // Upper limit; a shorter trajectory gives a shorter recording.
  double frame_rate_hz = 10.0;
  int frames_per_query = 5;
  double first_counted_s = 5.0;

  int max_features = 300;  // Per frame.
  double track_sigma_px = 1.0;
  double track_loss = 0.03;  // Probability per frame that a track ends.
  // Landmarks are placed around random poses of the trajectory, like walls.
  int num_landmarks = 20'000;
  double min_distance_m = 3.0;
  double max_distance_m = 16.0;
  double min_height_m = -1.6;  // Relative to the pose.
  double max_height_m = 4.0;

  int max_matches = 300;  // Per answer.
  double match_sigma_px = 1.0;
  double map_sigma_m = 0.05;  // Error of a mapped landmark per axis.
  double wrong_match_fraction = 0.0;
  // Standard deviations of the state at the start. Position and yaw define local and have no error.
  double start_tilt_sigma_rad = 0.01;
  double start_velocity_sigma_m_s = 0.05;
  double start_gyro_bias_sigma_rad_s = 0.002;
  double start_accel_bias_sigma_m_s2 = 0.03;
  uint64_t seed = 1;

  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;
};

// Returns the state at the first frame that an estimator starts from. Its error is drawn from the
// covariance that comes with it; the `start_*` options give the standard deviations. Local has its
// origin and heading at this frame. `truth` holds pose and velocity in global.
StartState DrawStart(const ImuState& truth, const RecordingOptions& options,
                     std::mt19937_64* random);

// Deterministic by seed. Throws the Error(kInvalidArgument) of Validate, and Error(kBadInput) if
// the trajectory has fewer than two frames within its poses and samples.
Recording SimulateRecording(const Trajectory& trajectory, const RecordingOptions& options);

// Fits the constant biases and the vertical with which the samples agree best with the poses. Then
// turns `global` so that this vertical is its z axis; motion capture levels `global` only to a
// fraction of a degree. Compares the rate with the poses' rotation over half a second, and the
// specific force with their change of velocity over one second. Throws Error(kBadInput) if the
// samples or the poses span less than three seconds.
void FitToSamples(Trajectory* trajectory);

// Error of motion capture: white noise per axis and pose.
struct PoseNoise {
  double position_sigma_m = 0.002;
  // Markers on a small body cause errors of some mrad that last for seconds. The value is for 100
  // poses per second.
  double rotation_sigma_rad = 0.01;
};

// Replaces the poses by those that agree best with both the poses and the samples (a
// Rauch-Tung-Striebel smoother), and the biases by the biases at the first pose. A camera on the
// captured poses would shake relative to the IMU to which it is bolted.
//
// If poses are more than 20 ms apart, adds poses at the samples between them. Drops poses outside
// the samples. The trajectory must have been through FitToSamples. Throws Error(kBadInput) if fewer
// than two poses remain, and Error(kInvalidArgument) if a sigma is not positive.
void SmoothPoses(const PoseNoise& pose_noise, const ImuNoise& imu_noise, Trajectory* trajectory);

}  // namespace cairn::fusion

#endif  // CAIRN_EVAL_RECORDINGS_SIMULATE_RECORDING_H_
