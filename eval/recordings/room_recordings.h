// Trajectories and inertial samples of real devices that were moved through rooms under motion
// capture. Simulated cameras are attached to them.
#ifndef CAIRN_EVAL_RECORDINGS_ROOM_RECORDINGS_H_
#define CAIRN_EVAL_RECORDINGS_ROOM_RECORDINGS_H_

#include <string>
#include <vector>

#include "eval/recordings/simulate_recording.h"

namespace cairn::fusion {

struct Room {
  Trajectory trajectory;
  RecordingOptions options;  // With the noise of the trajectory's samples.
};

// EuRoC V1_01 easy and V1_02 medium: a quadcopter, which stands for the first five seconds of
// V1_01. The camera looks along the IMU's z axis; the IMU's x axis is up. `folder` holds
// euroc_V1_01_easy/mav0 in EuRoC's layout, and vi_imu_gt/euroc_V1_02_medium/imu.csv and
// groundtruth.csv. Both throw the errors of ReadTrajectory.
Room EurocV101(const std::string& folder);
Room EurocV102(const std::string& folder);

// TUM-VI room 1: a hand-held device. The camera looks against the IMU's y axis; the IMU's z axis is
// up. `folder` holds vi_imu_gt/tumvi_room1/imu.csv and groundtruth.csv. Throws the errors of
// ReadTrajectory.
Room TumRoom1(const std::string& folder);

// Returns all three rooms.
std::vector<Room> AllRooms(const std::string& folder);

}  // namespace cairn::fusion

#endif  // CAIRN_EVAL_RECORDINGS_ROOM_RECORDINGS_H_
