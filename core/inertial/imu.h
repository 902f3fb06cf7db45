// Inertial measurements, and the part of the state that they propagate.
#ifndef CAIRN_CORE_INERTIAL_IMU_H_
#define CAIRN_CORE_INERTIAL_IMU_H_

#include <Eigen/Core>
#include <cstdint>

#include "core/rigid3.h"

namespace cairn::fusion {

// One reading of the IMU, in the IMU's frame.
struct ImuSample {
  int64_t timestamp_ns = 0;
  Eigen::Vector3d gyro_rad_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_m_s2 = Eigen::Vector3d::Zero();  // Specific force: +g upward at rest.
};

// Continuous-time noise of an IMU. The defaults are those of the ADIS16448 in the EuRoC recordings,
// a good unit. Phones are a few times noisier.
struct ImuNoise {
  double gyro_density = 1.7e-4;   // rad / s / sqrt(Hz), positive.
  double accel_density = 2.0e-3;  // m / s^2 / sqrt(Hz), positive.
  double gyro_walk = 2.0e-5;      // rad / s^2 / sqrt(Hz), of the bias's random walk, positive.
  double accel_walk = 3.0e-3;     // m / s^3 / sqrt(Hz), of the bias's random walk, positive.
};

// The part of the state that moves. The `local` frame is z-up.
struct ImuState {
  Rigid3d local_from_imu;
  Eigen::Vector3d velocity_in_local = Eigen::Vector3d::Zero();  // m/s.
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();          // rad/s.
  Eigen::Vector3d accel_bias = Eigen::Vector3d::Zero();         // m/s^2.
};

}  // namespace cairn::fusion

#endif  // CAIRN_CORE_INERTIAL_IMU_H_
