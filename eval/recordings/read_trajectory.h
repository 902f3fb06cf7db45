// Reads real trajectories: inertial samples and poses of a device in EuRoC's format.
#ifndef CAIRN_EVAL_RECORDINGS_READ_TRAJECTORY_H_
#define CAIRN_EVAL_RECORDINGS_READ_TRAJECTORY_H_

#include <string>

#include "eval/recordings/simulate_recording.h"

namespace cairn::fusion {

// Reads the samples and poses of a trajectory and prepares them. Both files are comma-separated;
// '#' starts a comment.
// - `imu_path`: nanoseconds, rate x y z in rad/s, specific force x y z in m/s^2.
// - `poses_path`: nanoseconds, position x y z, quaternion w x y z of the IMU; more columns are
//   ignored.
// The result is the longest stretch in which successive poses are at most 60 ms apart. FitToSamples
// fits its biases and vertical; SmoothPoses with `imu_noise` removes the noise of motion capture
// from its poses. Throws Error(kNotFound) or Error(kBadInput) that names the file and the line.
Trajectory ReadTrajectory(const std::string& name, const std::string& imu_path,
                          const std::string& poses_path, const ImuNoise& imu_noise);

}  // namespace cairn::fusion

#endif  // CAIRN_EVAL_RECORDINGS_READ_TRAJECTORY_H_
