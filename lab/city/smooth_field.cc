#include "lab/city/smooth_field.h"

#include <Eigen/Geometry>
#include <cmath>

#include "core/angles.h"
#include "lab/city/hashed_random.h"

namespace cairn {

SmoothField::SmoothField(uint64_t seed, double sigma_m, double min_wave_m) {
  constexpr double kTurnRad = 2.0 * kPi;
  HashedRandom random(seed);
  // A wave has half the square of its amplitude as variance.
  const double amplitude_m = sigma_m * std::sqrt(2.0 / static_cast<double>(waves_.size()));
  for (Wave& wave : waves_) {
    const double direction_rad = random.Uniform(0.0, kTurnRad);
    const double radians_per_m = kTurnRad / random.Uniform(min_wave_m, 3.0 * min_wave_m);
    wave.radians_per_m =
        radians_per_m * Eigen::Vector2d(std::cos(direction_rad), std::sin(direction_rad));
    wave.amplitude_m =
        amplitude_m * Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal());
    wave.phase_rad = random.Uniform(0.0, kTurnRad);
  }
}

Eigen::Vector3d SmoothField::ShiftM(const Eigen::Vector2d& at) const {
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  for (const Wave& wave : waves_) {
    shift += std::sin(wave.radians_per_m.dot(at) + wave.phase_rad) * wave.amplitude_m;
  }
  return shift;
}

Eigen::Vector3d SmoothField::RotationRad(const Eigen::Vector2d& at) const {
  Eigen::Vector3d curl = Eigen::Vector3d::Zero();
  for (const Wave& wave : waves_) {
    const Eigen::Vector3d gradient(wave.radians_per_m.x(), wave.radians_per_m.y(), 0.0);
    curl +=
        std::cos(wave.radians_per_m.dot(at) + wave.phase_rad) * gradient.cross(wave.amplitude_m);
  }
  return 0.5 * curl;
}

}  // namespace cairn
