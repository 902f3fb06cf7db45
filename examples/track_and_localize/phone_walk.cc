#include "phone_walk.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "cli/demo/street/build_street.h"
#include "eval/recordings/measure_motion.h"
#include "eval/recordings/motion.h"

namespace cairn {
namespace {

constexpr double kStandS = 2.0;
constexpr double kRampS = 2.0;
constexpr double kSpeedMS = 1.2;
constexpr double kFirstXM = 10.0;  // Start of the walk, along the street.
constexpr double kHeightM = 1.5;
constexpr double kFromKerbM = 1.2;  // Inward from the facade's edge of the pavement.

// Returns 0 while standing and 1 while walking, with a smooth transition.
double Pace(double time_s) {
  const double u = std::clamp((time_s - kStandS) / kRampS, 0.0, 1.0);
  return u * u * u * (10.0 - 15.0 * u + 6.0 * u * u);
}

// Integral of kSpeedMS * Pace.
double DistanceM(double time_s) {
  const double u = std::clamp((time_s - kStandS) / kRampS, 0.0, 1.0);
  const double u4 = u * u * u * u;
  return kSpeedMS *
         (kRampS * u4 * (2.5 - 3.0 * u + u * u) + std::max(0.0, time_s - kStandS - kRampS));
}

}  // namespace

int64_t PhoneTimeNs(double time_s) { return static_cast<int64_t>(std::llround(1e9 * time_s)); }

fusion::Rig PhoneWalk::PhoneRig() {
  Eigen::Matrix3d cam_from_imu;
  cam_from_imu << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return {Rigid3d(cam_from_imu, Eigen::Vector3d(0.03, 0.01, -0.05)), 0.0};
}

Rigid3d PhoneWalk::EnuFromImu(double time_s) const {
  const double pace = Pace(time_s);
  const double side_m = -0.5 * street_.width_m + kSidewalkM - kFromKerbM;
  const Eigen::Vector3d x_in_street(kFirstXM + DistanceM(time_s),
                                    side_m + pace * 0.08 * std::sin(5.6 * time_s),
                                    kHeightM + pace * 0.025 * std::sin(11.3 * time_s));
  const double yaw_rad = 0.25 + pace * 0.35 * std::sin(0.45 * (time_s - kStandS));
  const double pitch_rad = -0.05 + pace * 0.03 * std::sin(5.6 * time_s + 1.0);
  const double roll_rad = pace * 0.03 * std::sin(2.8 * time_s);
  const Eigen::Quaterniond street_from_imu =
      Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) *
      Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitY()) *
      Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitX());
  return EnuFromStreet(street_) * Rigid3d(street_from_imu, x_in_street);
}

std::vector<fusion::ImuSample> PhoneWalk::Measure(double duration_s, double rate_hz,
                                                  const fusion::ImuNoise& noise,
                                                  uint64_t seed) const {
  fusion::InertialUnit unit{.rate_hz = rate_hz, .noise = noise};
  unit.noise.gyro_walk = unit.noise.accel_walk = 0.0;
  unit.gyro_bias = {0.004, -0.003, 0.002};
  unit.accel_bias = {0.04, -0.03, 0.05};
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto normal_vectors = [&](int64_t) {
    const double x = normal(random), y = normal(random), z = normal(random);
    return Eigen::Vector3d(x, y, z);
  };
  const int num_samples = static_cast<int>(duration_s * rate_hz) + 2;
  return fusion::MeasureMotion(
             fusion::MotionAlong([this](double time_s) { return EnuFromImu(time_s); }), num_samples,
             unit, normal_vectors)
      .imu;
}

}  // namespace cairn
