#include "engine/index/distance_kernels.h"

#include "engine/index/intrinsics.h"

namespace cairn {
namespace {

int32_t PlainSqDistance(const int16_t* query, const uint8_t* row, int stride) {
  int32_t sum = 0;
  for (int begin = 0; begin < stride; begin += kDistanceBlock) {
    for (int j = 0; j < kDistanceBlock; ++j) {
      const int32_t difference = query[begin + j] - row[begin + j];
      sum += difference * difference;
    }
  }
  return sum;
}

void PlainScan(const int16_t* query, const uint8_t* rows, int stride, size_t count,
               int32_t* sq_distances) {
  for (size_t i = 0; i < count; ++i) {
    sq_distances[i] = PlainSqDistance(query, rows + i * stride, stride);
  }
}

constexpr DistanceKernels kPlain = {"plain", PlainScan};

#if defined(__x86_64__)

// Returns eight partial sums of one row's squared distance.
CAIRN_AVX2 inline __m256i Avx2PartialSums(const int16_t* query, const uint8_t* row, int stride) {
  __m256i sums = _mm256_setzero_si256();
  for (int begin = 0; begin < stride; begin += kDistanceBlock) {
    const __m128i bytes = _mm_loadu_si128(reinterpret_cast<const __m128i*>(row + begin));
    const __m256i values = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(query + begin));
    const __m256i difference = _mm256_sub_epi16(values, _mm256_cvtepu8_epi16(bytes));
    sums = _mm256_add_epi32(sums, _mm256_madd_epi16(difference, difference));
  }
  return sums;
}

// Returns the sum over the eight lanes of each argument, in order.
CAIRN_AVX2 inline __m128i Avx2ReduceFour(__m256i a, __m256i b, __m256i c, __m256i d) {
  const __m256i sums = _mm256_hadd_epi32(_mm256_hadd_epi32(a, b), _mm256_hadd_epi32(c, d));
  return _mm_add_epi32(_mm256_castsi256_si128(sums), _mm256_extracti128_si256(sums, 1));
}

CAIRN_AVX2 void Avx2Scan(const int16_t* query, const uint8_t* rows, int stride, size_t count,
                         int32_t* sq_distances) {
  size_t i = 0;
  for (; i + 4 <= count; i += 4) {
    const uint8_t* row = rows + i * stride;
    const __m128i four = Avx2ReduceFour(Avx2PartialSums(query, row, stride),
                                        Avx2PartialSums(query, row + stride, stride),
                                        Avx2PartialSums(query, row + 2 * stride, stride),
                                        Avx2PartialSums(query, row + 3 * stride, stride));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(sq_distances + i), four);
  }
  PlainScan(query, rows + i * stride, stride, count - i, sq_distances + i);
}

constexpr DistanceKernels kAvx2 = {"avx2", Avx2Scan};

#endif

}  // namespace

const DistanceKernels& BestDistanceKernels() {
  static const DistanceKernels& best = *SupportedDistanceKernels().back();
  return best;
}

std::vector<const DistanceKernels*> SupportedDistanceKernels() {
  std::vector<const DistanceKernels*> supported = {&kPlain};
#if defined(__x86_64__)
  if (HasAvx2()) {
    supported.push_back(&kAvx2);
  }
#endif
  return supported;
}

}  // namespace cairn
