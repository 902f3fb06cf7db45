// A simulated recording: inertial samples, tracks, truth, and a map that answers queries.
#ifndef CAIRN_TESTS_FUSION_SIMULATION_H_
#define CAIRN_TESTS_FUSION_SIMULATION_H_

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <random>
#include <unordered_map>
#include <vector>

#include "core/camera.h"
#include "eval/recordings/figure_of_eight.h"
#include "fusion/estimator/fusion_options.h"
#include "fusion/estimator/fusion_types.h"

namespace cairn::fusion::testing {

struct SimulationOptions {
  uint64_t seed = 1;
  double duration_s = 30.0;
  double imu_rate_hz = 200.0;
  double frame_rate_hz = 10.0;
  int num_features = 150;
  double pixel_sigma_px = 1.0;
  double outlier_fraction = 0.0;  // Share of tracked observations that are off by up to 30 px.
  double track_loss = 0.03;       // Probability that a track ends, per frame.
  int landmarks_per_meter = 25;   // Along the path.
  // If max_depth_m is positive, landmarks are placed in view of the frames between these depths
  // instead. Every frame then shows num_features of them, and landmarks are visible up to
  // max_depth_m. The simulator of OpenVINS (Geneva et al. 2020) does the same with 5 and 7 m.
  double min_depth_m = 0.0;
  double max_depth_m = 0.0;
  ImuNoise imu_noise;
  Eigen::Vector3d gyro_bias = {0.004, -0.003, 0.002};  // Biases at the start.
  Eigen::Vector3d accel_bias = {0.04, -0.03, 0.05};
  // Errors of the map: noise of each landmark, and the offset that all landmarks of a tile share.
  double map_sigma_m = 0.0;
  double tile_sigma_m = 0.0;
  double tile_size_m = 40.0;
  FigureOfEightOptions walk;
};

// The truth at one frame.
struct FrameTruth {
  int64_t timestamp_ns = 0;
  Rigid3d world_from_imu;
  Eigen::Vector3d velocity_in_world;
  Eigen::Vector3d gyro_bias;
  Eigen::Vector3d accel_bias;
};

struct SimulatedFrame {
  FrameTruth truth;
  std::vector<TrackedFeature> features;
};

// Deviations of an answer from the truth.
struct AnswerOptions {
  int max_matches = 100;
  double wrong_fraction = 0.0;  // Share of matches with a wrong landmark.
  // Moves the pose and the landmarks: an answer that is consistent but wrong.
  Rigid3d global_from_true_global;
};

// The world frame of the motion is the map's `global` frame.
class Simulation {
 public:
  explicit Simulation(const SimulationOptions& options);

  // Uses the recorded inertial samples and poses of a real device. Poses exist for every time in
  // [frame_times_ns.front(), frame_times_ns.back()].
  Simulation(const SimulationOptions& options, std::vector<ImuSample> imu,
             const std::vector<FrameTruth>& frames);

  const SimulationOptions& options() const { return options_; }
  const std::vector<ImuSample>& imu() const { return imu_; }
  const std::vector<SimulatedFrame>& frames() const { return frames_; }

  // Options that fit the simulated sensors.
  FusionOptions MatchingFusionOptions() const;

  // Returns the state at a frame, in the frame `local` that has its origin and yaw there. The state
  // is perturbed by a draw from the covariance that comes with it. Position and yaw are exact by
  // definition.
  StartState DrawStart(size_t frame, uint64_t seed) const;

  // Returns the true state at a frame, with the small covariance of OpenVINS' simulator.
  StartState TrueStart(size_t frame) const;

  // Returns the true local_from_world of an estimator that starts at a frame.
  Rigid3d LocalFromWorld(size_t frame) const;

  // Returns the map's answer to a query about frame `frame`.
  Answer MakeAnswer(const Query& query, size_t frame, const AnswerOptions& options) const;

  // Returns the frame that a query is about.
  size_t FrameOfQuery(const Query& query) const;

 private:
  // Fills imu_ and returns the truth at the frames.
  std::vector<FrameTruth> WalkAndMeasure();
  void ScatterLandmarks(const std::vector<FrameTruth>& frames);
  void ScatterLandmarksInView(const std::vector<FrameTruth>& frames);
  void TrackLandmarks(const std::vector<FrameTruth>& frames);
  std::vector<int> VisibleLandmarks(const Rigid3d& cam_from_world) const;
  uint64_t TileOf(const Eigen::Vector3d& x_in_world) const;
  Eigen::Vector3d MapPosition(int landmark) const;

  SimulationOptions options_;
  Camera camera_;
  Rig rig_;
  std::mt19937_64 random_;
  std::vector<ImuSample> imu_;
  std::vector<Eigen::Vector3d> landmarks_;
  std::vector<SimulatedFrame> frames_;
  std::unordered_map<uint64_t, int> landmark_of_track_;
};

// A walk with the defaults; `seed` is that of noise, landmarks and path.
Simulation SimulateWalk(double duration_s, uint64_t seed = 1);

// Feeds a simulation to an estimator in the order of time, starting at a frame with the state
// `start`. Calls `after_frame` with each frame's index after the estimator has processed the frame.
template <typename EstimatorType, typename Callback>
void ReplayFrom(const Simulation& simulation, size_t start_frame, const StartState& start,
                EstimatorType* estimator, const Callback& after_frame) {
  size_t next_imu = 0;
  const auto& imu = simulation.imu();
  for (size_t i = start_frame; i < simulation.frames().size(); ++i) {
    const SimulatedFrame& frame = simulation.frames()[i];
    while (next_imu < imu.size() && imu[next_imu].timestamp_ns <= frame.truth.timestamp_ns) {
      estimator->AddImu(imu[next_imu++]);
    }
    if (next_imu < imu.size()) {
      estimator->AddImu(imu[next_imu++]);
    }
    if (i == start_frame) {
      estimator->StartAt(frame.truth.timestamp_ns, start);
    } else {
      estimator->AddFrame({frame.truth.timestamp_ns, frame.features});
    }
    after_frame(i);
  }
}

// Same as above, starting with the seeded draw of the frame's state.
template <typename EstimatorType, typename Callback>
void Replay(const Simulation& simulation, size_t start_frame, EstimatorType* estimator,
            const Callback& after_frame) {
  ReplayFrom(simulation, start_frame, simulation.DrawStart(start_frame, simulation.options().seed),
             estimator, after_frame);
}

}  // namespace cairn::fusion::testing

#endif  // CAIRN_TESTS_FUSION_SIMULATION_H_
