// Constants of angles.
#ifndef CAIRN_CORE_ANGLES_H_
#define CAIRN_CORE_ANGLES_H_

#include <numbers>

namespace cairn {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kDegPerRad = 180.0 / kPi;
inline constexpr double kRadPerDeg = kPi / 180.0;

}  // namespace cairn

#endif  // CAIRN_CORE_ANGLES_H_
