// Random numbers that are the same on every platform and with every compiler.
#ifndef CAIRN_CORE_RANDOM_H_
#define CAIRN_CORE_RANDOM_H_

#include <cstdint>
#include <random>

namespace cairn {

inline constexpr uint64_t kSplitMixStep = 0x9E3779B97F4A7C15u;

// The output function of SplitMix64 (Steele, Lea, Flood 2014): a bijection. Neighboring inputs
// give independent outputs.
inline uint64_t HashWord(uint64_t value) {
  value += kSplitMixStep;
  value = (value ^ (value >> 30)) * 0xBF58476D1CE4E5B9u;
  value = (value ^ (value >> 27)) * 0x94D049BB133111EBu;
  return value ^ (value >> 31);
}

// Returns the index-th output of the SplitMix64 generator with this seed, without generating the
// outputs before it. A bijection of `index`, so comparisons of values have no ties.
inline uint64_t RandomBits(uint64_t seed, uint64_t index) {
  return HashWord(seed + index * kSplitMixStep);
}

// The SplitMix64 generator. Needs no setup. Not thread-safe.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}

  uint64_t Next() {
    const uint64_t bits = HashWord(state_);
    state_ += kSplitMixStep;
    return bits;
  }

  // Uniform in [0, size); `size` is positive. The bias is below size / 2^32.
  int Index(int size) {
    return static_cast<int>(((Next() >> 32) * static_cast<uint64_t>(size)) >> 32);
  }

  // Uniform in [0, 1).
  double Fraction() { return static_cast<double>(Next() >> 11) * 0x1p-53; }

 private:
  uint64_t state_;
};

// Distributions for std::mt19937_64; the standard specifies the generator's bits but not the
// distributions. Ingest uses them, so changing them would change the maps.
//
// Uniform in [0, 1).
inline double UniformUnit(std::mt19937_64* rng) { return ((*rng)() >> 11) * 0x1.0p-53; }

// Uniform in [0, count); count must be positive.
inline uint64_t UniformIndex(uint64_t count, std::mt19937_64* rng) { return (*rng)() % count; }

}  // namespace cairn

#endif  // CAIRN_CORE_RANDOM_H_
