// Random numbers that are the same on every platform and compiler; private to ingest.
#ifndef CAIRN_INGEST_RANDOM_H_
#define CAIRN_INGEST_RANDOM_H_

#include <cstdint>
#include <random>

namespace cairn {

// Uniform in [0, 1); unlike std::uniform_real_distribution fixed by the generator alone.
inline double UniformUnit(std::mt19937_64* rng) { return ((*rng)() >> 11) * 0x1.0p-53; }

// Uniform in [0, count); count must be positive.
inline uint64_t UniformIndex(uint64_t count, std::mt19937_64* rng) { return (*rng)() % count; }

}  // namespace cairn

#endif  // CAIRN_INGEST_RANDOM_H_
