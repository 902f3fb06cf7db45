// Real trajectories: inertial samples and poses of a device, as EuRoC's data sets have them.
#ifndef CAIRN_LAB_RECORDINGS_READ_TRAJECTORY_H_
#define CAIRN_LAB_RECORDINGS_READ_TRAJECTORY_H_

#include <string>

#include "lab/recordings/simulate_recording.h"

namespace cairn::fusion {

// Reads `imu_path` (nanoseconds, rate x y z in rad/s, specific force x y z in m/s^2) and
// `poses_path` (nanoseconds, position x y z, quaternion w x y z of the imu, more columns ignored);
// comma-separated, '#' begins a comment. Keeps the longest stretch in which successive poses are
// not more than 60 ms apart, fits biases and vertical on it (FitToSamples) and takes the noise of
// motion capture out of its poses (SmoothPoses with `imu_noise`). Throws Error(kNotFound) or
// Error(kBadInput) naming file and line.
Trajectory ReadTrajectory(const std::string& name, const std::string& imu_path,
                          const std::string& poses_path, const ImuNoise& imu_noise);

}  // namespace cairn::fusion

#endif  // CAIRN_LAB_RECORDINGS_READ_TRAJECTORY_H_
