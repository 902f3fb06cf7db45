#include "eval/recordings/room_recordings.h"

#include "eval/recordings/read_trajectory.h"

namespace cairn::fusion {
namespace {

// The noise with which poses and samples are smoothed. The values are the published ones, except
// for the accelerometer in flight. Velocities integrated over 0.1 to 2 s were compared with the
// poses. Their errors are four to eight times as large as the published density and walk (2e-3,
// 3e-3) allow, and 0.7 to 2.2 times as large as the values below allow.
ImuNoise EurocSmoothingNoise() {
  ImuNoise noise;
  noise.gyro_density = 1.7e-4;
  noise.gyro_walk = 2.0e-5;
  noise.accel_density = 1.0e-2;
  noise.accel_walk = 3.0e-2;
  return noise;
}

ImuNoise TumSmoothingNoise() {
  ImuNoise noise;
  noise.gyro_density = 1.6e-4;
  noise.gyro_walk = 2.2e-5;
  noise.accel_density = 2.8e-3;
  noise.accel_walk = 8.6e-4;
  return noise;
}

// A room of a few meters. `cam_from_imu` is the mounting of the device's camera, to the nearest
// axis.
RecordingOptions RoomRecordingOptions(const Eigen::Matrix3d& cam_from_imu) {
  RecordingOptions options;
  options.rig = {Rigid3d(cam_from_imu, Eigen::Vector3d(0.02, -0.06, 0.01)), 0.0};
  options.min_distance_m = 2.5;
  options.max_distance_m = 8.0;
  options.min_height_m = -2.5;
  options.max_height_m = 3.0;
  options.duration_s = 200.0;
  return options;
}

// The quadcopter of both EuRoC flights.
RecordingOptions EurocRecordingOptions() {
  Eigen::Matrix3d cam_from_imu;
  cam_from_imu << 0, 1, 0, -1, 0, 0, 0, 0, 1;
  RecordingOptions options = RoomRecordingOptions(cam_from_imu);
  // The walks were measured from the remaining differences between samples and smoothed poses, over
  // 0.1 to 10 s (docs/math/fusion.md).
  options.imu_noise = EurocSmoothingNoise();
  options.imu_noise.gyro_walk = 2.0e-4;
  return options;
}

RecordingOptions TumRecordingOptions() {
  Eigen::Matrix3d cam_from_imu;
  cam_from_imu << -1, 0, 0, 0, 0, -1, 0, -1, 0;
  RecordingOptions options = RoomRecordingOptions(cam_from_imu);
  // Measured in the same way. The published noise of the accelerometer is half of the measured one.
  options.imu_noise = TumSmoothingNoise();
  options.imu_noise.gyro_walk = 6.0e-5;
  options.imu_noise.accel_density = 5.0e-3;
  options.imu_noise.accel_walk = 2.5e-3;
  return options;
}

}  // namespace

Room EurocV101(const std::string& folder) {
  const std::string dir = folder + "/euroc_V1_01_easy/mav0";
  return {ReadTrajectory("EuRoC V1_01", dir + "/imu0/data.csv",
                         dir + "/state_groundtruth_estimate0/data.csv", EurocSmoothingNoise()),
          EurocRecordingOptions()};
}

Room EurocV102(const std::string& folder) {
  const std::string dir = folder + "/vi_imu_gt/euroc_V1_02_medium";
  return {ReadTrajectory("EuRoC V1_02", dir + "/imu.csv", dir + "/groundtruth.csv",
                         EurocSmoothingNoise()),
          EurocRecordingOptions()};
}

Room TumRoom1(const std::string& folder) {
  const std::string dir = folder + "/vi_imu_gt/tumvi_room1";
  return {ReadTrajectory("TUM-VI room1", dir + "/imu.csv", dir + "/groundtruth.csv",
                         TumSmoothingNoise()),
          TumRecordingOptions()};
}

std::vector<Room> AllRooms(const std::string& folder) {
  return {EurocV101(folder), EurocV102(folder), TumRoom1(folder)};
}

}  // namespace cairn::fusion
