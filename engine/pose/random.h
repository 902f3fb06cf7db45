// The random numbers of sample consensus.
#ifndef CAIRN_ENGINE_POSE_RANDOM_H_
#define CAIRN_ENGINE_POSE_RANDOM_H_

#include <cstdint>

namespace cairn {

// SplitMix64 (Steele, Lea, Flood 2014): the same sequence on every platform, nothing to set up. Not
// thread-safe.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}

  uint64_t Next() {
    uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
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

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_RANDOM_H_
