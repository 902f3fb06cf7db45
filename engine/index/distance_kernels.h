// Squared distances between a query and rows of bytes, the innermost loop of matching. There is a
// portable variant, and variants for wider vector units that are chosen at run time.
#ifndef CAIRN_ENGINE_INDEX_DISTANCE_KERNELS_H_
#define CAIRN_ENGINE_INDEX_DISTANCE_KERNELS_H_

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cairn {

// A row has `stride` bytes, the query `stride` int16 values in [-1024, 1279]. stride is a multiple
// of kDistanceBlock, at most kMaxDistanceStride. Results are integers, so every variant returns the
// same.
inline constexpr int kDistanceBlock = 16;
inline constexpr int kMaxDistanceStride = 128;

struct DistanceKernels {
  const char* name;  // "plain", "avx2".

  // sq_distances[i] = |query - rows[i]|^2, for i < count.
  void (*scan)(const int16_t* query, const uint8_t* rows, int stride, size_t count,
               int32_t* sq_distances);
};

// Returns the fastest variant that this processor supports.
const DistanceKernels& BestDistanceKernels();

// Returns every variant that this processor supports, the portable one first. For tests and
// benchmarks.
std::vector<const DistanceKernels*> SupportedDistanceKernels();

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_DISTANCE_KERNELS_H_
