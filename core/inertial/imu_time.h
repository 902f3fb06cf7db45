// Converts durations between seconds, as in options, and nanoseconds, as in timestamps.
#ifndef CAIRN_CORE_INERTIAL_IMU_TIME_H_
#define CAIRN_CORE_INERTIAL_IMU_TIME_H_

#include <cstdint>

namespace cairn::fusion {

inline double ToSeconds(int64_t duration_ns) { return 1e-9 * static_cast<double>(duration_ns); }

// Rounds toward zero.
inline int64_t ToNanoseconds(double duration_s) { return static_cast<int64_t>(duration_s * 1e9); }

}  // namespace cairn::fusion

#endif  // CAIRN_CORE_INERTIAL_IMU_TIME_H_
