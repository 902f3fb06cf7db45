// Random bits addressed by position instead of drawn in sequence.
#ifndef CAIRN_ENGINE_MATCHING_RANDOM_BITS_H_
#define CAIRN_ENGINE_MATCHING_RANDOM_BITS_H_

#include <cstdint>

namespace cairn {

// The index-th output of the SplitMix64 generator of this seed (Steele, Lea, Flood 2014): a
// bijection of the index, so that values can be compared without ties.
inline uint64_t RandomBits(uint64_t seed, uint64_t index) {
  uint64_t z = seed + (index + 1) * 0x9E3779B97F4A7C15u;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

}  // namespace cairn

#endif  // CAIRN_ENGINE_MATCHING_RANDOM_BITS_H_
