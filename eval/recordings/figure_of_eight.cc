#include "eval/recordings/figure_of_eight.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "core/angles.h"

namespace cairn::fusion {
namespace {

// amplitude * sin(omega t + phase), and its first two derivatives.
struct Wave {
  double value, first, second;
};

Wave Sine(double amplitude, double omega, double phase, double t) {
  const double s = std::sin(omega * t + phase);
  const double c = std::cos(omega * t + phase);
  return {amplitude * s, amplitude * omega * c, -amplitude * omega * omega * s};
}

// A ramp from 0 to 1 over one second, its integral and its derivative.
double Ramp(double x) { return x <= 0.0 ? 0.0 : x >= 1.0 ? 1.0 : x * x * (3.0 - 2.0 * x); }
double RampIntegral(double x) {
  return x <= 0.0 ? 0.0 : x >= 1.0 ? x - 0.5 : x * x * x * (1.0 - 0.5 * x);
}
double RampDerivative(double x) { return x <= 0.0 || x >= 1.0 ? 0.0 : 6.0 * x * (1.0 - x); }

}  // namespace

FigureOfEight::FigureOfEight(const FigureOfEightOptions& options) : options_(options) {
  std::mt19937_64 random(options.seed);
  std::uniform_real_distribution<double> angle(0.0, 2.0 * kPi);
  for (double& phase : phases_) {
    phase = angle(random);
  }
  // Keeps the path an eight: other phases have cusps, at which no one walks.
  phases_[1] = 2.0 * phases_[0] + std::uniform_real_distribution<double>(-0.5, 0.5)(random);
  width_ratio_ = std::uniform_real_distribution<double>(0.35, 0.6)(random);
  // Mean speed of (A sin wt, B sin 2wt) is about 0.64 w (A + 1.6 B) for these ratios.
  omega_ = options.speed_m_s / (0.64 * options.size_m * (1.0 + 1.6 * width_ratio_));
}

FigureOfEight::PathTime FigureOfEight::Warp(double time_s) const {
  if (options_.start_stop_s.empty()) {
    return {time_s, 1.0, 0.0};
  }
  PathTime path{0.0, 0.0, 0.0};
  double sign = 1.0;
  for (const double change_s : options_.start_stop_s) {
    path.tau += sign * RampIntegral(time_s - change_s);
    path.rate += sign * Ramp(time_s - change_s);
    path.acceleration += sign * RampDerivative(time_s - change_s);
    sign = -sign;
  }
  return path;
}

MotionState FigureOfEight::At(double time_s) const {
  const PathTime path = Warp(time_s);
  const double t = path.tau;
  const Wave x = Sine(options_.size_m, omega_, phases_[0], t);
  const Wave y = Sine(options_.size_m * width_ratio_, 2.0 * omega_, phases_[1], t);
  const Wave z = Sine(options_.gait_m, 2.0 * kPi * 1.8, phases_[2], t);
  const Wave look = Sine(options_.look_around_rad, 2.0 * kPi * 0.11, phases_[3], t);
  const Wave pitch = Sine(0.05, 2.0 * kPi * 0.9, phases_[4], t);
  const Wave roll = Sine(0.04, 2.0 * kPi * 0.7, phases_[5], t);

  const Eigen::Vector3d first(x.first, y.first, z.first);
  const Eigen::Vector3d second(x.second, y.second, z.second);
  const double heading = std::atan2(y.first, x.first);
  const double heading_rate =
      (x.first * y.second - y.first * x.second) / first.head<2>().squaredNorm();
  const double yaw = heading + look.value;
  const double yaw_rate = (heading_rate + look.first) * path.rate;
  const double pitch_rate = pitch.first * path.rate;
  const double roll_rate = roll.first * path.rate;

  MotionState state;
  const Eigen::Quaterniond rotation = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                                      Eigen::AngleAxisd(pitch.value, Eigen::Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(roll.value, Eigen::Vector3d::UnitX());
  state.world_from_imu = Rigid3d(rotation, Eigen::Vector3d(x.value, y.value, 1.6 + z.value));
  state.velocity_in_world = first * path.rate;
  state.acceleration_in_world = second * path.rate * path.rate + first * path.acceleration;
  const double sr = std::sin(roll.value), cr = std::cos(roll.value);
  const double sp = std::sin(pitch.value), cp = std::cos(pitch.value);
  state.rate_in_imu << roll_rate - yaw_rate * sp, pitch_rate * cr + yaw_rate * cp * sr,
      -pitch_rate * sr + yaw_rate * cp * cr;
  return state;
}

}  // namespace cairn::fusion
