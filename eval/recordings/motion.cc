#include "eval/recordings/motion.h"

#include <array>
#include <utility>

namespace cairn::fusion {
namespace {

constexpr double kStepS = 1e-3;

MotionState Differentiate(const std::function<Rigid3d(double)>& world_from_imu, double time_s) {
  std::array<Rigid3d, 5> poses;
  for (int i = -2; i <= 2; ++i) {
    poses[static_cast<size_t>(i + 2)] = world_from_imu(time_s + i * kStepS);
  }
  const auto at = [&](int steps) -> const Eigen::Vector3d& {
    return poses[static_cast<size_t>(steps + 2)].translation;
  };
  const auto turn = [&](int steps) {
    const Eigen::Quaterniond& before = poses[static_cast<size_t>(2 - steps)].rotation;
    const Eigen::Quaterniond& after = poses[static_cast<size_t>(2 + steps)].rotation;
    return LogSo3(before.conjugate() * after);
  };
  MotionState state;
  state.world_from_imu = poses[2];
  state.velocity_in_world = (8.0 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12.0 * kStepS);
  state.acceleration_in_world =
      (16.0 * (at(1) + at(-1)) - (at(2) + at(-2)) - 30.0 * at(0)) / (12.0 * kStepS * kStepS);
  // The turns are taken about the middle. Expressed in the IMU's frame at that time, they differ by
  // terms of third order.
  state.rate_in_imu = (8.0 * turn(1) - turn(2)) / (12.0 * kStepS);
  return state;
}

}  // namespace

Motion MotionAlong(std::function<Rigid3d(double time_s)> world_from_imu) {
  return [path = std::move(world_from_imu)](double time_s) { return Differentiate(path, time_s); };
}

}  // namespace cairn::fusion
