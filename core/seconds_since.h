// How long something took.
#ifndef CAIRN_CORE_SECONDS_SINCE_H_
#define CAIRN_CORE_SECONDS_SINCE_H_

#include <chrono>

namespace cairn {

// Returns the seconds from `start` to now.
inline double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace cairn

#endif  // CAIRN_CORE_SECONDS_SINCE_H_
