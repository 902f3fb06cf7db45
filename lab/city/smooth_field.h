// Simulates errors that vary slowly from place to place.
#ifndef CAIRN_LAB_CITY_SMOOTH_FIELD_H_
#define CAIRN_LAB_CITY_SMOOTH_FIELD_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace cairn {

// A random displacement of space: a sum of waves along the ground. Immutable.
class SmoothField {
 public:
  // `sigma_m` is the standard deviation of each component. The wavelengths range from `min_wave_m`
  // to three times that length.
  SmoothField(uint64_t seed, double sigma_m, double min_wave_m);

  Eigen::Vector3d ShiftM(const Eigen::Vector2d& at) const;
  // The matching rotation as a rotation vector in radians: half the curl of the displacement.
  Eigen::Vector3d RotationRad(const Eigen::Vector2d& at) const;

 private:
  struct Wave {
    Eigen::Vector2d radians_per_m;
    Eigen::Vector3d amplitude_m;
    double phase_rad;
  };
  std::array<Wave, 6> waves_;
};

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_SMOOTH_FIELD_H_
