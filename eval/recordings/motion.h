// Motions of a simulated IMU.
#ifndef CAIRN_EVAL_RECORDINGS_MOTION_H_
#define CAIRN_EVAL_RECORDINGS_MOTION_H_

#include <Eigen/Core>
#include <functional>

#include "core/rigid3.h"

namespace cairn::fusion {

// At one instant. `world` is z-up.
struct MotionState {
  Rigid3d world_from_imu;
  Eigen::Vector3d velocity_in_world;      // m/s.
  Eigen::Vector3d acceleration_in_world;  // m/s^2, without gravity.
  Eigen::Vector3d rate_in_imu;            // rad/s.
};

// The state of a motion at a time in seconds.
using Motion = std::function<MotionState(double time_s)>;

// Returns the motion along a path that is smooth over milliseconds. Differences of fourth order
// give the derivatives with a relative error below 1e-6.
Motion MotionAlong(std::function<Rigid3d(double time_s)> world_from_imu);

}  // namespace cairn::fusion

#endif  // CAIRN_EVAL_RECORDINGS_MOTION_H_
