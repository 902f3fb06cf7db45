#include "engine/matching/cell_sketch.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <vector>

#include "engine/vector_clones.h"

#if defined(__x86_64__)
// GCC 12 takes the deliberately undefined registers of its own AVX-512 header for a mistake (bug
// 105593).
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <immintrin.h>
#endif

namespace cairn {
namespace {

using Entries = int32_t __attribute__((vector_size(kSketchEntries * sizeof(int32_t))));

constexpr int kUnitsPerCell = 256;
constexpr int kUnitsPerQuarter = kUnitsPerCell / 4;
constexpr int kBitsPerPair = 4;

// Where the quarters begin that each of a pair's sixteen values means, of its lower and its upper
// dimension.
constexpr Entries kLowerBegin =
    kUnitsPerQuarter * Entries{0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
constexpr Entries kUpperBegin =
    kUnitsPerQuarter * Entries{0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};

// Squared distances of a coordinate to the middles of quarters.
[[gnu::always_inline]] inline void SquaredDistances(int32_t coordinate, const Entries& begin,
                                                    Entries* sq_distances) {
  const Entries distances = begin + (kUnitsPerQuarter / 2 - coordinate);
  *sq_distances = distances * distances;
}

CAIRN_VECTOR_CLONES void FillTables(std::span<const int32_t> coordinates, int32_t* own,
                                    int32_t* crossing) {
  Entries lower = {};
  for (size_t dim = 0; dim < coordinates.size(); ++dim) {
    const bool is_upper = dim % 2 != 0;
    const Entries& begin = is_upper ? kUpperBegin : kLowerBegin;
    const int32_t in_cell = coordinates[dim] & (kUnitsPerCell - 1);
    const bool is_nearer_to_lower = in_cell < kUnitsPerCell / 2;
    const int32_t in_next = in_cell + (is_nearer_to_lower ? kUnitsPerCell : -kUnitsPerCell);
    Entries here, there;
    SquaredDistances(in_cell, begin, &here);
    SquaredDistances(in_next, begin, &there);
    const Entries added = there - here;
    const Entries sum = is_upper ? lower + here : here;
    lower = here;
    std::memcpy(own + dim / 2 * kSketchEntries, &sum, sizeof(sum));
    std::memcpy(crossing + dim * kSketchEntries, &added, sizeof(added));
  }
}

// Copies `own` to `across`, adding the crossings. Whole vectors at a time, as they are read again
// at once.
CAIRN_VECTOR_CLONES void AddCrossings(const int32_t* own, const int32_t* crossing, int num_pairs,
                                      uint32_t crossed_dims, int32_t* across) {
  for (int pair = 0; pair < num_pairs; ++pair) {
    Entries sum;
    std::memcpy(&sum, own + pair * kSketchEntries, sizeof(sum));
    for (int dim = 2 * pair; dim < 2 * pair + 2; ++dim) {
      Entries added;
      std::memcpy(&added, crossing + dim * kSketchEntries, sizeof(added));
      sum += added & -static_cast<int32_t>(crossed_dims >> dim & 1);  // Without a branch.
    }
    std::memcpy(across + pair * kSketchEntries, &sum, sizeof(sum));
  }
}

size_t PlainFilter(const SketchTable& table, int num_pairs, int32_t max_sum,
                   const uint32_t* sketches, const uint32_t* items, size_t count, uint32_t* kept) {
  size_t num_kept = 0;
  for (size_t i = 0; i < count; ++i) {
    uint32_t sketch = sketches[i];
    int32_t sum = 0;
    for (int pair = 0; pair < num_pairs; ++pair) {
      sum += table.sq_distances[pair * kSketchEntries + sketch % kSketchEntries];
      sketch >>= kBitsPerPair;
    }
    kept[num_kept] = items[i];
    num_kept += sum <= max_sum ? 1 : 0;  // Without a branch, which would be mispredicted.
  }
  return num_kept;
}

constexpr SketchKernels kPlain = {"plain", PlainFilter};

#if defined(__x86_64__)

__attribute__((target("avx2"))) size_t Avx2Filter(const SketchTable& table, int num_pairs,
                                                  int32_t max_sum, const uint32_t* sketches,
                                                  const uint32_t* items, size_t count,
                                                  uint32_t* kept) {
  const auto* entries = reinterpret_cast<const __m256i*>(table.sq_distances.data());
  const __m256i max_sums = _mm256_set1_epi32(max_sum);
  size_t num_kept = 0;
  size_t i = 0;
  for (; i + 8 <= count; i += 8) {
    __m256i sketch = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(sketches + i));
    __m256i sums = _mm256_setzero_si256();
    for (int pair = 0; pair < num_pairs; ++pair) {
      const __m256i low =
          _mm256_permutevar8x32_epi32(_mm256_load_si256(entries + 2 * pair), sketch);
      const __m256i high =
          _mm256_permutevar8x32_epi32(_mm256_load_si256(entries + 2 * pair + 1), sketch);
      // The fourth bit, moved to the sign, chooses between the halves.
      const __m256i chosen =
          _mm256_castps_si256(_mm256_blendv_ps(_mm256_castsi256_ps(low), _mm256_castsi256_ps(high),
                                               _mm256_castsi256_ps(_mm256_slli_epi32(sketch, 28))));
      sums = _mm256_add_epi32(sums, chosen);
      sketch = _mm256_srli_epi32(sketch, kBitsPerPair);
    }
    const __m256i beyond = _mm256_cmpgt_epi32(sums, max_sums);
    auto within = static_cast<uint32_t>(~_mm256_movemask_ps(_mm256_castsi256_ps(beyond))) & 0xFF;
    for (; within != 0; within &= within - 1) {
      kept[num_kept++] = items[i + std::countr_zero(within)];
    }
  }
  return num_kept + PlainFilter(table, num_pairs, max_sum, sketches + i, items + i, count - i,
                                kept + num_kept);
}

__attribute__((target("avx512f"))) size_t Avx512Filter(const SketchTable& table, int num_pairs,
                                                       int32_t max_sum, const uint32_t* sketches,
                                                       const uint32_t* items, size_t count,
                                                       uint32_t* kept) {
  const __m512i max_sums = _mm512_set1_epi32(max_sum);
  size_t num_kept = 0;
  for (size_t i = 0; i < count; i += 16) {
    const auto lanes = static_cast<__mmask16>(count - i < 16 ? (uint32_t{1} << (count - i)) - 1
                                                             : uint32_t{0xFFFF});
    __m512i sketch = _mm512_maskz_loadu_epi32(lanes, sketches + i);
    __m512i sums = _mm512_setzero_si512();
    for (int pair = 0; pair < num_pairs; ++pair) {
      const __m512i entries = _mm512_load_si512(table.sq_distances.data() + pair * kSketchEntries);
      sums = _mm512_add_epi32(sums, _mm512_permutexvar_epi32(sketch, entries));
      sketch = _mm512_srli_epi32(sketch, kBitsPerPair);
    }
    const __mmask16 within = _mm512_mask_cmple_epi32_mask(lanes, sums, max_sums);
    const __m512i found = _mm512_maskz_loadu_epi32(within, items + i);
    _mm512_storeu_si512(kept + num_kept, _mm512_maskz_compress_epi32(within, found));
    num_kept += std::popcount(static_cast<uint32_t>(within));
  }
  return num_kept;
}

constexpr SketchKernels kAvx2 = {"avx2", Avx2Filter};
constexpr SketchKernels kAvx512 = {"avx512", Avx512Filter};

#endif

std::vector<const SketchKernels*> FindSupported() {
  std::vector<const SketchKernels*> supported = {&kPlain};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) {
    supported.push_back(&kAvx2);
  }
  if (__builtin_cpu_supports("avx512f")) {
    supported.push_back(&kAvx512);
  }
#endif
  return supported;
}

}  // namespace

int32_t MaxSketchSum(double sq_distance, int num_hashed_dims) {
  constexpr double kMaxSum = 1e9;  // More than any sketch has.
  constexpr double kVariance = kUnitsPerQuarter * kUnitsPerQuarter / 12.0;
  const double variance = kVariance * std::min(num_hashed_dims, kSketchDims);
  const double sum = std::max(sq_distance, 3.0 * variance);
  return static_cast<int32_t>(std::min(std::ceil(sum), kMaxSum));
}

void SketchTables::SetQuery(std::span<const int32_t> coordinates) {
  const size_t num_dims = std::min<size_t>(coordinates.size(), kSketchDims);
  num_pairs_ = static_cast<int>(num_dims + 1) / 2;
  FillTables(coordinates.first(num_dims), own_.sq_distances.data(), crossing_.data());
}

const SketchTable& SketchTables::Across(uint32_t crossed_dims) {
  if (crossed_dims == 0) {
    return own_;
  }
  AddCrossings(own_.sq_distances.data(), crossing_.data(), num_pairs_, crossed_dims,
               across_.sq_distances.data());
  return across_;
}

std::span<const SketchKernels* const> SupportedSketchKernels() {
  static const std::vector<const SketchKernels*> supported = FindSupported();
  return supported;
}

const SketchKernels& BestSketchKernels() {
  static const SketchKernels& best = *SupportedSketchKernels().back();
  return best;
}

}  // namespace cairn
