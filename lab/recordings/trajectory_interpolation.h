// True poses between those of a trajectory.
#ifndef CAIRN_LAB_RECORDINGS_TRAJECTORY_INTERPOLATION_H_
#define CAIRN_LAB_RECORDINGS_TRAJECTORY_INTERPOLATION_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/rigid3.h"
#include "lab/recordings/simulate_recording.h"

namespace cairn::fusion {

// Spherical and linear; `timestamp_ns` must lie within the poses, of which there are at least 2.
Rigid3d PoseAt(const std::vector<TruePose>& poses, int64_t timestamp_ns);

// From the positions 20 ms before and after (within the poses).
Eigen::Vector3d VelocityAt(const std::vector<TruePose>& poses, int64_t timestamp_ns);

}  // namespace cairn::fusion

#endif  // CAIRN_LAB_RECORDINGS_TRAJECTORY_INTERPOLATION_H_
