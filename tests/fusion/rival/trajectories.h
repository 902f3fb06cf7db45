// Trajectories for comparisons: a simulated walk, and the real ones of the test data.
#ifndef CAIRN_TESTS_FUSION_RIVAL_TRAJECTORIES_H_
#define CAIRN_TESTS_FUSION_RIVAL_TRAJECTORIES_H_

#include <filesystem>

#include "fusion/motion.h"
#include "fusion/rival/read_trajectory.h"
#include "fusion/rival/simulate_recording.h"
#include "fusion/simulation.h"

namespace cairn::fusion::testing {

// The imu's x axis points ahead, its z axis up.
inline Rig RigAhead() {
  Eigen::Matrix3d cam_from_imu;
  cam_from_imu << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return {Rigid3d(cam_from_imu, Eigen::Vector3d(0.03, 0.01, -0.05)), 0.0};
}

inline Trajectory WalkTrajectory(double duration_s, uint64_t seed) {
  SimulationOptions options;
  options.seed = seed;
  options.walk.seed = seed;
  options.duration_s = duration_s;
  options.landmarks_per_metre = 1;
  options.num_features = 1;
  const Simulation simulation(options);
  const Walk walk(options.walk);
  Trajectory trajectory;
  trajectory.name = "simulated walk, seed " + std::to_string(seed);
  trajectory.imu = simulation.imu();
  trajectory.gyro_bias = options.gyro_bias;
  trajectory.accel_bias = options.accel_bias;
  for (const ImuSample& sample : trajectory.imu) {
    trajectory.poses.push_back(
        {sample.timestamp_ns,
         walk.At(1e-9 * static_cast<double>(sample.timestamp_ns)).world_from_imu});
  }
  return trajectory;
}

inline RecordingOptions WalkRecordingOptions(uint64_t seed) {
  RecordingOptions options;
  options.rig = RigAhead();
  options.seed = seed;
  return options;
}

// A room of some metres; `cam_from_imu` as the device's camera is mounted, to the nearest axis.
inline RecordingOptions RoomRecordingOptions(const Eigen::Matrix3d& cam_from_imu) {
  RecordingOptions options;
  options.rig = {Rigid3d(cam_from_imu, Eigen::Vector3d(0.02, -0.06, 0.01)), 0.0};
  options.min_distance_m = 2.5;
  options.max_distance_m = 8.0;
  options.min_height_m = -2.5;
  options.max_height_m = 3.0;
  options.duration_s = 200.0;
  return options;
}

// The camera looks along the imu's z axis, the imu's x axis is up.
inline RecordingOptions EurocRecordingOptions() {
  Eigen::Matrix3d cam_from_imu;
  cam_from_imu << 0, 1, 0, -1, 0, 0, 0, 0, 1;
  return RoomRecordingOptions(cam_from_imu);
}
inline Trajectory EurocTrajectory(const std::filesystem::path& vi_imu_gt) {
  const std::filesystem::path dir = vi_imu_gt / "euroc_V1_02_medium";
  return ReadTrajectory("EuRoC V1_02", dir / "imu.csv", dir / "groundtruth.csv");
}

// The camera looks against the imu's y axis, the imu's z axis is up.
inline RecordingOptions TumRecordingOptions() {
  Eigen::Matrix3d cam_from_imu;
  cam_from_imu << -1, 0, 0, 0, 0, -1, 0, -1, 0;
  RecordingOptions options = RoomRecordingOptions(cam_from_imu);
  options.imu_noise.gyro_density = 1.6e-4;
  options.imu_noise.accel_density = 2.8e-3;
  options.imu_noise.gyro_walk = 2.2e-5;
  options.imu_noise.accel_walk = 8.6e-4;
  return options;
}
inline Trajectory TumTrajectory(const std::filesystem::path& vi_imu_gt) {
  const std::filesystem::path dir = vi_imu_gt / "tumvi_room1";
  return ReadTrajectory("TUM-VI room1", dir / "imu.csv", dir / "groundtruth.csv");
}

}  // namespace cairn::fusion::testing

#endif  // CAIRN_TESTS_FUSION_RIVAL_TRAJECTORIES_H_
