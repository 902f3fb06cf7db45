// A simulated walk for comparisons.
#ifndef CAIRN_TESTS_LAB_RIVALS_FUSION_TRAJECTORIES_H_
#define CAIRN_TESTS_LAB_RIVALS_FUSION_TRAJECTORIES_H_

#include "fusion/motion.h"
#include "fusion/simulation.h"
#include "lab/recordings/simulate_recording.h"

namespace cairn::fusion::testing {

// The IMU's x axis points ahead, its z axis up.
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

}  // namespace cairn::fusion::testing

#endif  // CAIRN_TESTS_LAB_RIVALS_FUSION_TRAJECTORIES_H_
