// Motions with exact derivatives, for simulated IMUs.
#ifndef CAIRN_TESTS_FUSION_MOTION_H_
#define CAIRN_TESTS_FUSION_MOTION_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/rigid3.h"

namespace cairn::fusion::testing {

// `world` is z-up. The IMU's x axis points ahead, its z axis up.
struct MotionState {
  Rigid3d world_from_imu;
  Eigen::Vector3d velocity_in_world;
  Eigen::Vector3d acceleration_in_world;
  Eigen::Vector3d rate_in_imu;  // rad/s.
};

struct WalkOptions {
  uint64_t seed = 1;  // Seed of the path's shape and the gait's phases.
  double size_m =
      22.0;  // Half the length of the figure of eight; the path is some 6 times as long.
  double speed_m_s = 1.3;
  double gait_m = 0.025;         // Amplitude of the steps' bobbing at 1.8 Hz.
  double look_around_rad = 0.4;  // Amplitude of the slow turns of the head.
  // Times at which the walker starts (first, third, ...) and stops (second, ...) walking. Each
  // change takes one second. Empty: the walker never stops.
  std::vector<double> start_stop_s;
};

// A person walks along a figure of eight, looks around, and bobs with each step. Immutable.
class Walk {
 public:
  explicit Walk(const WalkOptions& options);

  MotionState At(double time_s) const;

 private:
  struct PathTime {
    double tau, rate, acceleration;  // Time along the path and its derivatives.
  };
  PathTime Warp(double time_s) const;

  WalkOptions options_;
  double omega_;
  double phases_[6];
  double width_ratio_;
};

}  // namespace cairn::fusion::testing

#endif  // CAIRN_TESTS_FUSION_MOTION_H_
