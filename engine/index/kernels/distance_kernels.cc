#include "engine/index/kernels/distance_kernels.h"

#if defined(__x86_64__)
// GCC 12 warns about the deliberately undefined registers in its own AVX-512 header (bug 105593).
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <immintrin.h>
#endif

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

void PlainGather(const int16_t* query, const uint8_t* rows, int stride, const uint32_t* indices,
                 size_t count, int32_t* sq_distances) {
  for (size_t i = 0; i < count; ++i) {
    sq_distances[i] = PlainSqDistance(query, rows + size_t{indices[i]} * stride, stride);
  }
}

void PlainScan(const int16_t* query, const uint8_t* rows, int stride, size_t count,
               int32_t* sq_distances) {
  for (size_t i = 0; i < count; ++i) {
    sq_distances[i] = PlainSqDistance(query, rows + i * stride, stride);
  }
}

constexpr DistanceKernels kPlain = {"plain", PlainGather, PlainScan};

#if defined(__x86_64__)

#define CAIRN_AVX2 __attribute__((target("avx2")))
#define CAIRN_AVX512 __attribute__((target("avx512f,avx512bw,avx512vl")))

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

CAIRN_AVX2 void Avx2Gather(const int16_t* query, const uint8_t* rows, int stride,
                           const uint32_t* indices, size_t count, int32_t* sq_distances) {
  const auto row = [&](size_t i) { return rows + size_t{indices[i]} * stride; };
  size_t i = 0;
  for (; i + 4 <= count; i += 4) {
    const __m128i four = Avx2ReduceFour(
        Avx2PartialSums(query, row(i), stride), Avx2PartialSums(query, row(i + 1), stride),
        Avx2PartialSums(query, row(i + 2), stride), Avx2PartialSums(query, row(i + 3), stride));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(sq_distances + i), four);
  }
  PlainGather(query, rows, stride, indices + i, count - i, sq_distances + i);
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

// Returns eight partial sums for each of two rows; the first row's are in the lower half.
CAIRN_AVX512 inline __m512i Avx512PartialSums(const int16_t* query, const uint8_t* row_a,
                                              const uint8_t* row_b, int stride) {
  __m512i sums = _mm512_setzero_si512();
  for (int begin = 0; begin < stride; begin += kDistanceBlock) {
    const __m128i a = _mm_loadu_si128(reinterpret_cast<const __m128i*>(row_a + begin));
    const __m128i b = _mm_loadu_si128(reinterpret_cast<const __m128i*>(row_b + begin));
    const __m512i bytes = _mm512_cvtepu8_epi16(_mm256_set_m128i(b, a));
    const __m512i values =
        _mm512_broadcast_i64x4(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(query + begin)));
    const __m512i difference = _mm512_sub_epi16(values, bytes);
    sums = _mm512_add_epi32(sums, _mm512_madd_epi16(difference, difference));
  }
  return sums;
}

// Returns the sums over the lower and upper halves of `ab` and `cd`, in order.
CAIRN_AVX512 inline __m128i Avx512ReduceFour(__m512i ab, __m512i cd) {
  return Avx2ReduceFour(_mm512_castsi512_si256(ab), _mm512_extracti64x4_epi64(ab, 1),
                        _mm512_castsi512_si256(cd), _mm512_extracti64x4_epi64(cd, 1));
}

CAIRN_AVX512 void Avx512Gather(const int16_t* query, const uint8_t* rows, int stride,
                               const uint32_t* indices, size_t count, int32_t* sq_distances) {
  const auto row = [&](size_t i) { return rows + size_t{indices[i]} * stride; };
  size_t i = 0;
  for (; i + 4 <= count; i += 4) {
    const __m128i four = Avx512ReduceFour(Avx512PartialSums(query, row(i), row(i + 1), stride),
                                          Avx512PartialSums(query, row(i + 2), row(i + 3), stride));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(sq_distances + i), four);
  }
  PlainGather(query, rows, stride, indices + i, count - i, sq_distances + i);
}

CAIRN_AVX512 void Avx512Scan(const int16_t* query, const uint8_t* rows, int stride, size_t count,
                             int32_t* sq_distances) {
  size_t i = 0;
  for (; i + 4 <= count; i += 4) {
    const uint8_t* row = rows + i * stride;
    const __m128i four =
        Avx512ReduceFour(Avx512PartialSums(query, row, row + stride, stride),
                         Avx512PartialSums(query, row + 2 * stride, row + 3 * stride, stride));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(sq_distances + i), four);
  }
  PlainScan(query, rows + i * stride, stride, count - i, sq_distances + i);
}

constexpr DistanceKernels kAvx2 = {"avx2", Avx2Gather, Avx2Scan};
constexpr DistanceKernels kAvx512 = {"avx512", Avx512Gather, Avx512Scan};

#endif

}  // namespace

const DistanceKernels& BestDistanceKernels() {
  static const DistanceKernels& best = *SupportedDistanceKernels().back();
  return best;
}

std::vector<const DistanceKernels*> SupportedDistanceKernels() {
  std::vector<const DistanceKernels*> supported = {&kPlain};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) {
    supported.push_back(&kAvx2);
  }
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512vl")) {
    supported.push_back(&kAvx512);
  }
#endif
  return supported;
}

}  // namespace cairn
