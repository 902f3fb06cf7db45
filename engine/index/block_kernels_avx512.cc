// The block kernels for AVX-512 with byte products (VNNI).
#if defined(__x86_64__)
#include <algorithm>
#include <cstring>
#include <limits>

#include "engine/index/block_kernel_variants.h"
#include "engine/index/intrinsics.h"

namespace cairn {
namespace {

// Computes the squared distances of one block after another. The usual case has its own code: rows
// of 16 bytes and a query of one part, which stays in registers.
class VnniQuery {
 public:
  CAIRN_AVX512VNNI VnniQuery(const BlockQuery& query, int stride)
      : query_(query),
        stride_(stride),
        is_small_(stride == kNumSmallGroups * kGroupDims && query.num_parts == 1),
        constant_(_mm512_set1_epi32(query.constant)) {
    for (int group = 0; group < kNumSmallGroups; ++group) {
      small_[group] = Values(query.parts + group * kGroupDims);
    }
  }

  CAIRN_AVX512VNNI __m512i SqDistances(const uint8_t* block, const int32_t* sq_norms) const {
    __m512i products = _mm512_setzero_si512();
    if (is_small_) {
      // Two independent sums, so that a product need not wait for the previous one.
      __m512i more_products = _mm512_setzero_si512();
      products = _mm512_dpbusd_epi32(products, Bytes(block, 0), small_[0]);
      more_products = _mm512_dpbusd_epi32(more_products, Bytes(block, 1), small_[1]);
      products = _mm512_dpbusd_epi32(products, Bytes(block, 2), small_[2]);
      more_products = _mm512_dpbusd_epi32(more_products, Bytes(block, 3), small_[3]);
      products = _mm512_add_epi32(products, more_products);
    } else {
      for (int part = 0; part < query_.num_parts; ++part) {
        for (int group = 0; group < stride_ / kGroupDims; ++group) {
          products =
              _mm512_dpbusd_epi32(products, Bytes(block, group),
                                  Values(query_.parts + part * stride_ + group * kGroupDims));
        }
      }
    }
    return _mm512_sub_epi32(_mm512_add_epi32(constant_, _mm512_loadu_si512(sq_norms)),
                            _mm512_slli_epi32(products, 1));
  }

 private:
  CAIRN_AVX512VNNI static __m512i Values(const int8_t* from) {
    int32_t four_values;
    std::memcpy(&four_values, from, sizeof(four_values));
    return _mm512_set1_epi32(four_values);
  }
  CAIRN_AVX512VNNI static __m512i Bytes(const uint8_t* block, int group) {
    return _mm512_loadu_si512(block + group * kBlockRows * kGroupDims);
  }

  const BlockQuery& query_;
  int stride_;
  bool is_small_;
  __m512i constant_;
  __m512i small_[kNumSmallGroups];  // The first groups.
};

CAIRN_AVX512VNNI void VnniScan(const BlockQuery& query, const uint8_t* blocks,
                               const int32_t* sq_norms, int stride, size_t num_blocks,
                               int32_t* sq_distances) {
  const VnniQuery vnni(query, stride);
  for (size_t i = 0; i < num_blocks; ++i) {
    _mm512_storeu_si512(
        sq_distances + i * kBlockRows,
        vnni.SqDistances(blocks + i * kBlockRows * stride, sq_norms + i * kBlockRows));
  }
}

CAIRN_AVX512VNNI size_t VnniNearest(const BlockQuery& query, const uint8_t* blocks,
                                    const int32_t* sq_norms, int stride, size_t num_rows) {
  const VnniQuery vnni(query, stride);
  // For each lane, the first of its nearest rows.
  __m512i nearest = _mm512_set1_epi32(std::numeric_limits<int32_t>::max());
  __m512i nearest_rows = _mm512_setzero_si512();
  __m512i rows = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  for (size_t first = 0; first < num_rows; first += kBlockRows) {
    const __m512i sq_distances = vnni.SqDistances(blocks + first * stride, sq_norms + first);
    const __mmask16 is_nearer = _mm512_cmplt_epi32_mask(sq_distances, nearest);
    nearest = _mm512_min_epi32(nearest, sq_distances);
    nearest_rows = _mm512_mask_mov_epi32(nearest_rows, is_nearer, rows);
    rows = _mm512_add_epi32(rows, _mm512_set1_epi32(kBlockRows));
  }
  alignas(64) int32_t sq_distances[kBlockRows], lane_rows[kBlockRows];
  _mm512_store_si512(sq_distances, nearest);
  _mm512_store_si512(lane_rows, nearest_rows);
  BlockHit candidates[kBlockRows];
  for (int lane = 0; lane < kBlockRows; ++lane) {
    candidates[lane] = {static_cast<uint32_t>(lane_rows[lane]), sq_distances[lane]};
  }
  return NearestOf(candidates, kBlockRows);
}

CAIRN_AVX512VNNI void VnniMinimaOfPart(const VnniQuery& vnni, const uint8_t* blocks,
                                       const int32_t* sq_norms, int stride, size_t first,
                                       size_t last, int32_t* minima) {
  __m512i smallest = _mm512_set1_epi32(std::numeric_limits<int32_t>::max());
  for (size_t i = first; i < last; ++i) {
    smallest = _mm512_min_epi32(
        smallest, vnni.SqDistances(blocks + i * kBlockRows * stride, sq_norms + i * kBlockRows));
  }
  _mm512_storeu_si512(minima, smallest);
}

CAIRN_AVX512VNNI void VnniMinima(const BlockQuery& query, const uint8_t* blocks,
                                 const int32_t* sq_norms, int stride, size_t num_blocks,
                                 size_t num_parts, int32_t* minima) {
  const VnniQuery vnni(query, stride);
  MinimaOfParts(num_blocks, num_parts, minima, [&](size_t first, size_t last, int32_t* smallest) {
    VnniMinimaOfPart(vnni, blocks, sq_norms, stride, first, last, smallest);
  });
}

// Appends the `near` rows of one block without a branch. May overwrite up to a whole block beyond
// the appended rows.
CAIRN_AVX512VNNI inline size_t VnniAppend(__m512i sq_distances, __mmask16 near, size_t first,
                                          BlockHit* hits) {
  const __m512i row_in_block =
      _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  const __m512i low_pairs =
      _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
  const __m512i high_pairs =
      _mm512_setr_epi32(8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
  const __m512i rows = _mm512_maskz_compress_epi32(
      near, _mm512_add_epi32(row_in_block, _mm512_set1_epi32(static_cast<int>(first))));
  const __m512i distances = _mm512_maskz_compress_epi32(near, sq_distances);
  _mm512_storeu_si512(hits, _mm512_permutex2var_epi32(rows, low_pairs, distances));
  _mm512_storeu_si512(hits + kBlockRows / 2,
                      _mm512_permutex2var_epi32(rows, high_pairs, distances));
  return static_cast<size_t>(__builtin_popcount(near));
}

// For at most kNotedBlocks blocks. Notes the blocks with hits without branches, as Avx2RangeOf
// does, and computes them again.
CAIRN_AVX512VNNI size_t VnniRangeOfFew(const VnniQuery& vnni, const uint8_t* blocks,
                                       const int32_t* sq_norms, int stride, size_t first,
                                       size_t begin, size_t end, __m512i bound, BlockHit* hits) {
  alignas(64) __mmask16 near[kNotedBlocks] = {};
  const size_t num_blocks = (end - first + kBlockRows - 1) / kBlockRows;
  const auto sq_distances = [&](size_t block) CAIRN_AVX512VNNI {
    return vnni.SqDistances(blocks + (first + block * kBlockRows) * stride,
                            sq_norms + first + block * kBlockRows);
  };
  for (size_t i = 0; i < num_blocks; ++i) {
    _store_mask16(&near[i], _mm512_cmple_epi32_mask(sq_distances(i), bound));
  }
  near[0] &= static_cast<__mmask16>(RowsInRange(first, begin, end));
  near[num_blocks - 1] &=
      static_cast<__mmask16>(RowsInRange(first + (num_blocks - 1) * kBlockRows, begin, end));
  const __m512i noted = _mm512_load_si512(near);
  size_t num_hits = 0;
  for (uint32_t left = _mm512_test_epi16_mask(noted, noted); left != 0; left &= left - 1) {
    const int i = __builtin_ctz(left);
    num_hits += VnniAppend(sq_distances(i), near[i], first + i * kBlockRows, hits + num_hits);
  }
  return num_hits;
}

CAIRN_AVX512VNNI size_t VnniRange(const BlockQuery& query, const uint8_t* blocks,
                                  const int32_t* sq_norms, int stride, size_t begin, size_t end,
                                  int32_t max_sq_distance, BlockHit* hits) {
  const VnniQuery vnni(query, stride);
  const __m512i bound = _mm512_set1_epi32(max_sq_distance);
  size_t num_hits = 0;
  for (size_t first = begin / kBlockRows * kBlockRows; first < end;
       first += kNotedBlocks * kBlockRows) {
    num_hits +=
        VnniRangeOfFew(vnni, blocks, sq_norms, stride, first, begin,
                       std::min(end, first + kNotedBlocks * kBlockRows), bound, hits + num_hits);
  }
  return num_hits;
}

}  // namespace

const BlockKernels kAvx512VnniBlockKernels = {"avx512vnni", VnniScan, VnniNearest, VnniMinima,
                                              VnniRange};

}  // namespace cairn

#endif
