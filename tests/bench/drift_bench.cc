// Measures the drift of local tracking without a map: 11 clones, 200 points at 10 Hz, a walk of 226
// m.
//
//   cairn_fusion_drift [num_runs] [scenario] [first seed]
//
// Prints the root mean square errors of position and rotation for each run and over all runs. "raw"
// errors are in the frame of the start. "aligned" errors are after the yaw and shift that fit the
// whole path best, as in papers. Also prints the normalized error squared of the pose and the CPU
// time per frame.
//
// Scenarios:
//   walk      landmarks at 4 to 16 m from the path, tracks that end at random, a start with errors
//   openvins  as in the simulator of OpenVINS (Geneva et al. 2020): landmarks in view at 5 to 7 m,
//             tracks that last as long as the point is in view, samples at 400 Hz, a true start
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string_view>
#include <vector>

#include "core/angles.h"
#include "fusion/errors.h"
#include "fusion/estimator/estimator.h"
#include "fusion/simulation.h"

namespace cairn::fusion::testing {
namespace {

constexpr double kLengthM = 226.0;

// Time after which a walk has the wanted length.
double Duration(const FigureOfEightOptions& options) {
  const FigureOfEight walk(options);
  double length_m = 0.0;
  double time_s = 0.0;
  while (length_m < kLengthM) {
    const Eigen::Vector3d before = walk.At(time_s).world_from_imu.translation;
    time_s += 0.1;
    length_m += (walk.At(time_s).world_from_imu.translation - before).norm();
  }
  return time_s;
}

SimulationOptions ScenarioOptions(std::string_view scenario, uint64_t seed) {
  SimulationOptions options;
  options.seed = seed;
  options.walk.seed = seed;
  options.duration_s = Duration(options.walk);
  options.num_features = 200;
  if (scenario == "openvins") {
    options.imu_rate_hz = 400.0;
    options.track_loss = 0.0;
    options.min_depth_m = 5.0;
    options.max_depth_m = 7.0;
  }
  return options;
}

struct PoseErrors {
  double position_m = 0.0, rotation_rad = 0.0;
};

struct RunResult {
  PoseErrors raw, aligned;
  double length_m = 0.0;
  double nees = 0.0;
  double ms_per_frame = 0.0;
  double tracks_per_frame = 0.0;
};

PoseErrors Errors(const std::vector<Rigid3d>& truth, const std::vector<Rigid3d>& estimate) {
  Rms position_m, rotation_rad;
  for (size_t i = 0; i < truth.size(); ++i) {
    position_m.Add((truth[i].translation - estimate[i].translation).norm());
    rotation_rad.Add(RotationAngleRad(truth[i].rotation, estimate[i].rotation));
  }
  return {position_m.Value(), rotation_rad.Value()};
}

// The estimate turned about the vertical and shifted onto the truth, by least squares.
std::vector<Rigid3d> Aligned(const std::vector<Rigid3d>& truth,
                             const std::vector<Rigid3d>& estimate) {
  Eigen::Vector3d truth_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d estimate_mean = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < truth.size(); ++i) {
    truth_mean += truth[i].translation / static_cast<double>(truth.size());
    estimate_mean += estimate[i].translation / static_cast<double>(truth.size());
  }
  double along = 0.0;
  double across = 0.0;
  for (size_t i = 0; i < truth.size(); ++i) {
    const Eigen::Vector2d to = (truth[i].translation - truth_mean).head<2>();
    const Eigen::Vector2d from = (estimate[i].translation - estimate_mean).head<2>();
    along += from.dot(to);
    across += from.x() * to.y() - from.y() * to.x();
  }
  const Eigen::Quaterniond turn = ExpSo3({0.0, 0.0, std::atan2(across, along)});
  const Rigid3d truth_from_estimate(turn, truth_mean - turn * estimate_mean);
  std::vector<Rigid3d> aligned;
  for (const Rigid3d& pose : estimate) {
    aligned.push_back(truth_from_estimate * pose);
  }
  return aligned;
}

RunResult RunOnce(std::string_view scenario, uint64_t seed) {
  const Simulation simulation(ScenarioOptions(scenario, seed));
  Estimator estimator(simulation.MatchingFusionOptions());
  const Rigid3d local_from_world = simulation.LocalFromWorld(0);
  std::vector<Rigid3d> truth, estimate;
  RunResult result;
  const std::clock_t begin = std::clock();
  const auto after_frame = [&](size_t i) {
    const FrameTruth& at = simulation.frames()[i].truth;
    truth.push_back(local_from_world * at.world_from_imu);
    estimate.push_back(estimator.state()->imu().local_from_imu);
    if (i > 5) {
      result.nees += Nees(ImuError(estimator.state()->imu(), at, local_from_world).head<6>(),
                          estimator.state()->covariance().topLeftCorner<6, 6>());
    }
  };
  if (scenario == "openvins") {
    ReplayFrom(simulation, 0, simulation.TrueStart(0), &estimator, after_frame);
  } else {
    Replay(simulation, 0, &estimator, after_frame);
  }
  const auto num_frames = static_cast<double>(truth.size());
  result.ms_per_frame =
      1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC / num_frames;
  for (size_t i = 1; i < truth.size(); ++i) {
    result.length_m += (truth[i].translation - truth[i - 1].translation).norm();
  }
  result.nees /= num_frames - 6.0;
  result.tracks_per_frame = static_cast<double>(estimator.counters().num_tracks_used) / num_frames;
  result.raw = Errors(truth, estimate);
  result.aligned = Errors(truth, Aligned(truth, estimate));
  return result;
}

void RunScenario(std::string_view scenario, int num_runs, int first_seed) {
  std::printf("%s\nseed  length m    raw m   deg  aligned m   deg   nees  ms/frame  tracks\n",
              scenario.data());
  Rms raw_m, raw_rad, aligned_m, aligned_rad;
  double nees = 0.0;
  for (int seed = first_seed; seed < first_seed + num_runs; ++seed) {
    const RunResult run = RunOnce(scenario, static_cast<uint64_t>(seed));
    std::printf("%4d  %8.0f  %7.3f %5.2f  %9.3f %5.2f %6.2f  %8.2f  %6.1f\n", seed, run.length_m,
                run.raw.position_m, kDegPerRad * run.raw.rotation_rad, run.aligned.position_m,
                kDegPerRad * run.aligned.rotation_rad, run.nees, run.ms_per_frame,
                run.tracks_per_frame);
    std::fflush(stdout);
    raw_m.Add(run.raw.position_m);
    raw_rad.Add(run.raw.rotation_rad);
    aligned_m.Add(run.aligned.position_m);
    aligned_rad.Add(run.aligned.rotation_rad);
    nees += run.nees / num_runs;
  }
  std::printf(" all            %7.3f %5.2f  %9.3f %5.2f %6.2f\n", raw_m.Value(),
              kDegPerRad * raw_rad.Value(), aligned_m.Value(), kDegPerRad * aligned_rad.Value(),
              nees);
}

}  // namespace
}  // namespace cairn::fusion::testing

int main(int argc, char** argv) {
  const int num_runs = argc > 1 ? std::atoi(argv[1]) : 5;
  const std::string_view wanted = argc > 2 ? argv[2] : "";
  const int first_seed = argc > 3 ? std::atoi(argv[3]) : 1;
  for (const std::string_view scenario : {"walk", "openvins"}) {
    if (wanted.empty() || wanted == scenario) {
      cairn::fusion::testing::RunScenario(scenario, num_runs, first_seed);
    }
  }
  return 0;
}
