// The rooms in which real devices were carried about under motion capture: their trajectories and
// inertial samples, to be seen by simulated cameras.
#ifndef CAIRN_LAB_RECORDINGS_ROOM_RECORDINGS_H_
#define CAIRN_LAB_RECORDINGS_ROOM_RECORDINGS_H_

#include <string>
#include <vector>

#include "lab/recordings/simulate_recording.h"

namespace cairn::fusion {

struct Room {
  Trajectory trajectory;
  RecordingOptions options;  // With the noise of the trajectory's samples.
};

// EuRoC V1_01 easy and V1_02 medium: a quadcopter, which in V1_01 stands for its first five
// seconds. The camera looks along the imu's z axis, the imu's x axis is up. `folder` holds
// euroc_V1_01_easy/mav0 as EuRoC lays it out, and vi_imu_gt/euroc_V1_02_medium/imu.csv and
// groundtruth.csv. Throw as ReadTrajectory.
Room EurocV101(const std::string& folder);
Room EurocV102(const std::string& folder);

// TUM-VI room 1: a device in the hand. The camera looks against the imu's y axis, the imu's z axis
// is up. `folder` holds vi_imu_gt/tumvi_room1/imu.csv and groundtruth.csv. Throws as
// ReadTrajectory.
Room TumRoom1(const std::string& folder);

// All of them.
std::vector<Room> AllRooms(const std::string& folder);

}  // namespace cairn::fusion

#endif  // CAIRN_LAB_RECORDINGS_ROOM_RECORDINGS_H_
