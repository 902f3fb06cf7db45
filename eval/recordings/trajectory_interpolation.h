// Interpolates the true poses of a trajectory.
#ifndef CAIRN_EVAL_RECORDINGS_TRAJECTORY_INTERPOLATION_H_
#define CAIRN_EVAL_RECORDINGS_TRAJECTORY_INTERPOLATION_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/rigid3.h"
#include "eval/recordings/simulate_recording.h"

namespace cairn::fusion {

// Interpolates the rotation spherically and the position linearly. `timestamp_ns` must be within
// the poses, of which there are at least 2.
Rigid3d PoseAt(const std::vector<TruePose>& poses, int64_t timestamp_ns);

// Returns the velocity from the positions 20 ms before and after, both within the poses.
Eigen::Vector3d VelocityAt(const std::vector<TruePose>& poses, int64_t timestamp_ns);

}  // namespace cairn::fusion

#endif  // CAIRN_EVAL_RECORDINGS_TRAJECTORY_INTERPOLATION_H_
