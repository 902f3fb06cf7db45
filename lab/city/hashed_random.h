// Random numbers that are functions of names. They do not depend on the order of the calls, the
// time or the machine.
#ifndef CAIRN_LAB_CITY_HASHED_RANDOM_H_
#define CAIRN_LAB_CITY_HASHED_RANDOM_H_

#include <cmath>
#include <cstdint>

#include "core/angles.h"
#include "core/random.h"

namespace cairn {

// Hashes several numbers into one. Their order matters. Words are integers or enumerators.
template <typename... Words>
uint64_t HashOf(uint64_t first, Words... words) {
  uint64_t hash = HashWord(first);
  ((hash = HashWord(hash ^ static_cast<uint64_t>(words))), ...);
  return hash;
}

// A short sequence of random numbers that a hash determines.
class HashedRandom {
 public:
  explicit HashedRandom(uint64_t hash) : state_(hash) {}

  uint64_t Next() { return HashWord(state_ += 0x2545f4914f6cdd1d); }
  // Uniform in [0, 1).
  double Uniform() { return static_cast<double>(Next() >> 11) * 0x1.0p-53; }
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  bool Chance(double probability) { return Uniform() < probability; }
  // Uniform in [0, count); count must be positive.
  int Index(int count) { return static_cast<int>(Next() % static_cast<uint64_t>(count)); }
  // Standard normal (Box and Muller).
  double Normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform()));
    return radius * std::cos(2.0 * kPi * Uniform());
  }

 private:
  uint64_t state_;
};

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_HASHED_RANDOM_H_
