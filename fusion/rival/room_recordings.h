// The rooms in which real devices were carried about under motion capture: their trajectories and
// inertial samples, to be seen by simulated cameras.
#ifndef CAIRN_FUSION_RIVAL_ROOM_RECORDINGS_H_
#define CAIRN_FUSION_RIVAL_ROOM_RECORDINGS_H_

#include <string>

#include "fusion/rival/simulate_recording.h"

namespace cairn::fusion {

// EuRoC V1_02 medium: a quadcopter. The camera looks along the imu's z axis, the imu's x axis is
// up. `folder` holds euroc_V1_02_medium/imu.csv and groundtruth.csv. Throws as ReadTrajectory.
Trajectory EurocTrajectory(const std::string& folder);
RecordingOptions EurocRecordingOptions();

// TUM-VI room 1: a device in the hand. The camera looks against the imu's y axis, the imu's z axis
// is up. `folder` holds tumvi_room1/imu.csv and groundtruth.csv. Throws as ReadTrajectory.
Trajectory TumTrajectory(const std::string& folder);
RecordingOptions TumRecordingOptions();

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_RIVAL_ROOM_RECORDINGS_H_
