// A simulated walk for comparisons.
#ifndef CAIRN_TESTS_LAB_TRAJECTORIES_H_
#define CAIRN_TESTS_LAB_TRAJECTORIES_H_

#include <random>
#include <string>
#include <utility>

#include "eval/recordings/figure_of_eight.h"
#include "eval/recordings/measure_motion.h"
#include "eval/recordings/simulate_recording.h"

namespace cairn::fusion::testing {

// The IMU's x axis points ahead, its z axis up.
inline Rig RigAhead() {
  Eigen::Matrix3d cam_from_imu;
  cam_from_imu << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return {Rigid3d(cam_from_imu, Eigen::Vector3d(0.03, 0.01, -0.05)), 0.0};
}

inline Trajectory WalkTrajectory(double duration_s, uint64_t seed) {
  FigureOfEightOptions options;
  options.seed = seed;
  const FigureOfEight path(options);
  InertialUnit unit;
  unit.gyro_bias = {0.004, -0.003, 0.002};
  unit.accel_bias = {0.04, -0.03, 0.05};
  std::mt19937_64 random(seed);
  const auto normal_vector = [&random](int64_t) {
    std::normal_distribution<double> normal;
    const double x = normal(random);
    const double y = normal(random);
    const double z = normal(random);
    return Eigen::Vector3d(x, y, z);
  };
  const int num_samples = static_cast<int>(duration_s * unit.rate_hz) + 2;
  InertialWalk walk = MeasureMotion([&path](double time_s) { return path.At(time_s); }, num_samples,
                                    unit, normal_vector);
  Trajectory trajectory;
  trajectory.name = "simulated walk, seed " + std::to_string(seed);
  trajectory.gyro_bias = unit.gyro_bias;
  trajectory.accel_bias = unit.accel_bias;
  for (size_t i = 0; i < walk.imu.size(); ++i) {
    trajectory.poses.push_back({walk.imu[i].timestamp_ns, walk.truth[i].local_from_imu});
  }
  trajectory.imu = std::move(walk.imu);
  return trajectory;
}

inline RecordingOptions WalkRecordingOptions(uint64_t seed) {
  RecordingOptions options;
  options.rig = RigAhead();
  options.seed = seed;
  return options;
}

}  // namespace cairn::fusion::testing

#endif  // CAIRN_TESTS_LAB_TRAJECTORIES_H_
