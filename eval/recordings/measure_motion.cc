#include "eval/recordings/measure_motion.h"

#include <cmath>

namespace cairn::fusion {

InertialWalk MeasureMotion(const Motion& motion, int num_samples, const InertialUnit& unit,
                           const NormalVectors& normal_vectors) {
  const double step_s = 1.0 / unit.rate_hz;
  const double root_step = std::sqrt(step_s);
  const Eigen::Vector3d up(0.0, 0.0, unit.gravity_m_s2);
  Eigen::Vector3d gyro_bias = unit.gyro_bias;
  Eigen::Vector3d accel_bias = unit.accel_bias;
  InertialWalk walk;
  for (int i = 0; i < num_samples; ++i) {
    const auto draw = [&](double sigma) -> Eigen::Vector3d {
      return sigma > 0.0 ? Eigen::Vector3d(sigma * normal_vectors(i)) : Eigen::Vector3d::Zero();
    };
    const double time_s = i * step_s;
    const MotionState at = motion(time_s);
    const Eigen::Vector3d force =
        at.world_from_imu.rotation.conjugate() * (at.acceleration_in_world + up);
    ImuSample& sample = walk.imu.emplace_back();
    sample.timestamp_ns = std::llround(1e9 * time_s);
    sample.gyro_rad_s = at.rate_in_imu + gyro_bias + draw(unit.noise.gyro_density / root_step);
    sample.accel_m_s2 = force + accel_bias + draw(unit.noise.accel_density / root_step);
    walk.truth.push_back({at.world_from_imu, at.velocity_in_world, gyro_bias, accel_bias});
    gyro_bias += draw(unit.noise.gyro_walk * root_step);
    accel_bias += draw(unit.noise.accel_walk * root_step);
  }
  return walk;
}

}  // namespace cairn::fusion
