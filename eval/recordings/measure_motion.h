// Simulates an IMU on a motion: samples with noise and random-walk biases, and the true states.
#ifndef CAIRN_EVAL_RECORDINGS_MEASURE_MOTION_H_
#define CAIRN_EVAL_RECORDINGS_MEASURE_MOTION_H_

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/inertial/imu.h"
#include "eval/recordings/motion.h"

namespace cairn::fusion {

struct InertialUnit {
  double rate_hz = 200.0;
  ImuNoise noise;                                        // A density may be 0 here.
  Eigen::Vector3d gyro_bias = Eigen::Vector3d::Zero();   // Initial bias, rad/s.
  Eigen::Vector3d accel_bias = Eigen::Vector3d::Zero();  // Initial bias, m/s^2.
  double gravity_m_s2 = 9.81;
};

// Returns three independent standard normal numbers. MeasureMotion calls it four times a sample,
// for the noise of the rate, the noise of the specific force, the step of the rate's bias, and the
// step of the force's bias. It omits the call where the density is 0.
using NormalVectors = std::function<Eigen::Vector3d(int64_t sample_idx)>;

// `truth` is parallel to `imu`. The `local` frame of `truth` is the `world` of the motion.
struct InertialWalk {
  std::vector<ImuSample> imu;
  std::vector<ImuState> truth;
};

// Measures at the times 0, 1 / rate_hz, ..., which are also the timestamps. Deterministic if
// `normal_vectors` is.
InertialWalk MeasureMotion(const Motion& motion, int num_samples, const InertialUnit& unit,
                           const NormalVectors& normal_vectors);

}  // namespace cairn::fusion

#endif  // CAIRN_EVAL_RECORDINGS_MEASURE_MOTION_H_
