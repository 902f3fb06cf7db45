// Random streams that city_surface.cc and surface_landmarks.cc share. Private to the two.
#ifndef CAIRN_LAB_CITY_SURFACE_STREAMS_H_
#define CAIRN_LAB_CITY_SURFACE_STREAMS_H_

#include <cmath>
#include <cstdint>

namespace cairn {

// Streams of random numbers that must stay separate.
enum SurfaceStream : uint64_t {
  kGroundStream = 0x201,
  kTreeStream,
  kSignStream,
  kParkingStream,
  kElement,
  kUnique,
  kSlotTiming,
};

// Returns the number of the thing that occupies a place at a time. Things in one place succeed each
// other.
inline int64_t EpochAt(double time_years, double lifetime_years, double phase) {
  return static_cast<int64_t>(std::floor(time_years / lifetime_years + phase));
}

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_SURFACE_STREAMS_H_
