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
#include "fusion/client/fusion_options.h"
#include "fusion/client/fusion_types.h"
#include "fusion/motion.h"

namespace cairn::fusion::testing {

struct SimulationOptions {
  uint64_t seed = 1;
  double duration_s = 30.0;
  double imu_rate_hz = 200.0;
  double frame_rate_hz = 10.0;
  int num_features = 150;
  double pixel_sigma_px = 1.0;
  double outlier_fraction = 0.0;  // Of tracked sights, off by up to 30 px.
  double track_loss = 0.03;       // Probability that a track ends, per frame.
  int landmarks_per_metre = 25;   // Along the path.
  // If max_depth_m is positive: landmarks stand in view of the frames at these depths instead, as
  // many as make every frame show num_features of them, and are seen up to max_depth_m. So does the
  // simulator of OpenVINS (Geneva et al. 2020), with 5 and 7 m.
  double min_depth_m = 0.0;
  double max_depth_m = 0.0;
  ImuNoise imu_noise;
  Eigen::Vector3d gyro_bias = {0.004, -0.003, 0.002};  // At the start.
  Eigen::Vector3d accel_bias = {0.04, -0.03, 0.05};
  // Of the map: per-landmark noise and the offset that all landmarks of a tile share.
  double map_sigma_m = 0.0;
  double tile_sigma_m = 0.0;
  double tile_size_m = 40.0;
  WalkOptions walk;
};

// Truth at a frame.
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

// How an answer departs from the truth.
struct AnswerOptions {
  int max_matches = 100;
  double wrong_fraction = 0.0;      // Matches with another landmark.
  Rigid3d global_from_true_global;  // Applied to pose and landmarks: a consistent but wrong answer.
};

// The world frame of the motion is the map's `global`.
class Simulation {
 public:
  explicit Simulation(const SimulationOptions& options);

  // As above, but with the recorded inertial samples and poses of a real device; `poses` may be
  // asked for any time in [frame_times_ns.front(), frame_times_ns.back()].
  Simulation(const SimulationOptions& options, std::vector<ImuSample> imu,
             const std::vector<FrameTruth>& frames);

  const SimulationOptions& options() const { return options_; }
  const std::vector<ImuSample>& imu() const { return imu_; }
  const std::vector<SimulatedFrame>& frames() const { return frames_; }

  // Options that fit the simulated sensors.
  FusionOptions MatchingOptions() const;

  // The state at a frame in the frame `local` that has its origin and yaw there, perturbed by a
  // draw from the covariance that comes with it; position and yaw are exact by definition.
  StartState DrawStart(size_t frame, uint64_t seed) const;

  // The true state at a frame, with the small covariance that the simulator of OpenVINS gives it.
  StartState TrueStart(size_t frame) const;

  // The true local_from_world of an estimator started there.
  Rigid3d LocalFromWorld(size_t frame) const;

  // The map's answer to a query of frame `frame`.
  Answer MakeAnswer(const Query& query, size_t frame, const AnswerOptions& options) const;

  // The frame that a query was made of.
  size_t FrameOfQuery(const Query& query) const;

 private:
  void MakeImu();
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
  std::vector<FrameTruth> bias_truth_;
  std::vector<Eigen::Vector3d> landmarks_;
  std::vector<SimulatedFrame> frames_;
  std::unordered_map<uint64_t, int> landmark_of_track_;
};

// Feeds a simulation to an estimator from a frame on, whose state is `start`, in the order of time,
// and calls `after_frame` with each frame's index once it has been processed.
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

// As above, from the seeded draw of the frame's state.
template <typename EstimatorType, typename Callback>
void Replay(const Simulation& simulation, size_t start_frame, EstimatorType* estimator,
            const Callback& after_frame) {
  ReplayFrom(simulation, start_frame, simulation.DrawStart(start_frame, simulation.options().seed),
             estimator, after_frame);
}

}  // namespace cairn::fusion::testing

#endif  // CAIRN_TESTS_FUSION_SIMULATION_H_
