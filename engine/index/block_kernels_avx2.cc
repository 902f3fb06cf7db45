// The block kernels for AVX2.
#if defined(__x86_64__)
#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "engine/index/block_kernel_variants.h"
#include "engine/index/intrinsics.h"

namespace cairn {
namespace {

// The Avx2...Query classes multiply a query with eight rows of a block at a time. This class takes
// any query.
class Avx2AnyQuery {
 public:
  Avx2AnyQuery(const BlockQuery& query, int stride) : query_(query), stride_(stride) {}

  // Returns twice the products with the lower (half = 0) or upper rows.
  CAIRN_AVX2 __m256i TwiceProducts(const uint8_t* block, int half) const {
    const auto* bytes = reinterpret_cast<const __m256i*>(block) + half;
    __m256i products = _mm256_setzero_si256();
    for (int group = 0; group < stride_ / kGroupDims; ++group) {
      const int16_t* values = query_.values + group * kGroupDims;
      products = _mm256_add_epi32(products,
                                  Products(bytes[2 * group], Values(values), Values(values + 2)));
    }
    return _mm256_slli_epi32(products, 1);
  }

  // Returns two neighboring values in every lane.
  CAIRN_AVX2 static __m256i Values(const int16_t* from) {
    int32_t two_values;
    std::memcpy(&two_values, from, sizeof(two_values));
    return _mm256_set1_epi32(two_values);
  }
  // Returns the products of one group. Even and odd bytes are multiplied separately.
  CAIRN_AVX2 static __m256i Products(const __m256i& bytes, __m256i even_values,
                                     __m256i odd_values) {
    const __m256i rows = _mm256_loadu_si256(&bytes);
    const __m256i even = _mm256_and_si256(rows, _mm256_set1_epi16(0xff));
    return _mm256_add_epi32(_mm256_madd_epi16(even, even_values),
                            _mm256_madd_epi16(_mm256_srli_epi16(rows, 8), odd_values));
  }

 private:
  const BlockQuery& query_;
  int stride_;
};

CAIRN_AVX2 inline __m256i Sum(__m256i a, __m256i b, __m256i c, __m256i d) {
  return _mm256_add_epi32(_mm256_add_epi32(a, b), _mm256_add_epi32(c, d));
}

// Takes a small query: its values fit registers.
class Avx2SmallQuery {
 public:
  CAIRN_AVX2 explicit Avx2SmallQuery(const BlockQuery& query) {
    for (int group = 0; group < kNumSmallGroups; ++group) {
      even_[group] = Avx2AnyQuery::Values(query.values + group * kGroupDims);
      odd_[group] = Avx2AnyQuery::Values(query.values + group * kGroupDims + 2);
    }
  }
  CAIRN_AVX2 __m256i TwiceProducts(const uint8_t* block, int half) const {
    const auto* bytes = reinterpret_cast<const __m256i*>(block) + half;
    const auto products = [&](int group) CAIRN_AVX2 {
      return Avx2AnyQuery::Products(bytes[2 * group], even_[group], odd_[group]);
    };
    return _mm256_slli_epi32(Sum(products(0), products(1), products(2), products(3)), 1);
  }

 private:
  __m256i even_[kNumSmallGroups], odd_[kNumSmallGroups];
};

// Takes the usual query: small with narrow pairs. Its values are multiplied with the bytes as
// stored.
class Avx2NarrowQuery {
 public:
  CAIRN_AVX2 explicit Avx2NarrowQuery(const BlockQuery& query) {
    for (int group = 0; group < kNumSmallGroups; ++group) {
      parts_[group] = Values(query.parts + group * kGroupDims);
    }
  }
  CAIRN_AVX2 __m256i TwiceProducts(const uint8_t* block, int half) const {
    const auto* bytes = reinterpret_cast<const __m256i*>(block) + half;
    const auto products = [&](int group) CAIRN_AVX2 {
      return TwiceProducts(bytes + 2 * group, parts_[group]);
    };
    return Sum(products(0), products(1), products(2), products(3));
  }

  // Returns the values of one group in every lane.
  CAIRN_AVX2 static __m256i Values(const int8_t* from) {
    int32_t four_values;
    std::memcpy(&four_values, from, sizeof(four_values));
    return _mm256_set1_epi32(four_values);
  }
  // Of one group.
  CAIRN_AVX2 static __m256i TwiceProducts(const __m256i* bytes, __m256i values) {
    return _mm256_madd_epi16(_mm256_maddubs_epi16(_mm256_loadu_si256(bytes), values),
                             _mm256_set1_epi16(2));
  }

 private:
  __m256i parts_[kNumSmallGroups];
};

// Takes any query with narrow pairs.
class Avx2AnyNarrowQuery {
 public:
  Avx2AnyNarrowQuery(const BlockQuery& query, int stride) : parts_(query.parts), stride_(stride) {}

  CAIRN_AVX2 __m256i TwiceProducts(const uint8_t* block, int half) const {
    const auto* bytes = reinterpret_cast<const __m256i*>(block) + half;
    const auto of_group = [&](int group) CAIRN_AVX2 {
      return Avx2NarrowQuery::TwiceProducts(bytes + 2 * group,
                                            Avx2NarrowQuery::Values(parts_ + group * kGroupDims));
    };
    __m256i products = _mm256_setzero_si256();
    for (int group = 0; group < stride_ / kGroupDims; group += kNumSmallGroups) {
      products = _mm256_add_epi32(products, Sum(of_group(group), of_group(group + 1),
                                                of_group(group + 2), of_group(group + 3)));
    }
    return products;
  }

 private:
  const int8_t* parts_;
  int stride_;  // A multiple of 16 bytes.
};

// Calls use(q), where q is the query in its Avx2...Query class.
template <typename Use>
CAIRN_AVX2 inline auto WithAvx2Query(const BlockQuery& query, int stride, const Use& use) {
  if (stride != kNumSmallGroups * kGroupDims) {
    return query.has_narrow_pairs ? use(Avx2AnyNarrowQuery(query, stride))
                                  : use(Avx2AnyQuery(query, stride));
  }
  return query.has_narrow_pairs ? use(Avx2NarrowQuery(query)) : use(Avx2SmallQuery(query));
}

CAIRN_AVX2 inline __m256i Avx2Norms(const int32_t* sq_norms, int half) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(sq_norms) + half);
}

// Returns the squared distances of the lower (half = 0) or upper eight rows of a block, for a query
// with this constant.
template <typename Query>
CAIRN_AVX2 inline __m256i Avx2SqDistances(const Query& query, __m256i constant,
                                          const uint8_t* block, const int32_t* sq_norms, int half) {
  return _mm256_sub_epi32(_mm256_add_epi32(constant, Avx2Norms(sq_norms, half)),
                          query.TwiceProducts(block, half));
}

CAIRN_AVX2 void Avx2Scan(const BlockQuery& query, const uint8_t* blocks, const int32_t* sq_norms,
                         int stride, size_t num_blocks, int32_t* sq_distances) {
  const __m256i constant = _mm256_set1_epi32(query.constant);
  WithAvx2Query(query, stride, [&](const auto& avx2) CAIRN_AVX2 {
    for (size_t i = 0; i < num_blocks; ++i) {
      for (int half = 0; half < 2; ++half) {
        _mm256_storeu_si256(
            reinterpret_cast<__m256i*>(sq_distances + i * kBlockRows + half * kBlockRows / 2),
            Avx2SqDistances(avx2, constant, blocks + i * kBlockRows * stride,
                            sq_norms + i * kBlockRows, half));
      }
    }
  });
}

template <typename Query>
CAIRN_AVX2 size_t Avx2NearestTo(const Query& query, __m256i constant, const uint8_t* blocks,
                                const int32_t* sq_norms, int stride, size_t num_rows) {
  constexpr int kLanes = 8;
  // For each lane, the first of its nearest rows.
  __m256i nearest = _mm256_set1_epi32(std::numeric_limits<int32_t>::max());
  __m256i nearest_rows = _mm256_setzero_si256();
  __m256i rows = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  for (size_t first = 0; first < num_rows; first += kBlockRows) {
    for (int half = 0; half < 2; ++half) {
      const __m256i eight =
          Avx2SqDistances(query, constant, blocks + first * stride, sq_norms + first, half);
      const __m256i is_nearer = _mm256_cmpgt_epi32(nearest, eight);
      nearest = _mm256_min_epi32(nearest, eight);
      nearest_rows = _mm256_blendv_epi8(nearest_rows, rows, is_nearer);
      rows = _mm256_add_epi32(rows, _mm256_set1_epi32(kLanes));
    }
  }
  alignas(32) int32_t sq_distances[kLanes], lane_rows[kLanes];
  _mm256_store_si256(reinterpret_cast<__m256i*>(sq_distances), nearest);
  _mm256_store_si256(reinterpret_cast<__m256i*>(lane_rows), nearest_rows);
  BlockHit candidates[kLanes];
  for (int lane = 0; lane < kLanes; ++lane) {
    candidates[lane] = {static_cast<uint32_t>(lane_rows[lane]), sq_distances[lane]};
  }
  return NearestOf(candidates, kLanes);
}

CAIRN_AVX2 size_t Avx2Nearest(const BlockQuery& query, const uint8_t* blocks,
                              const int32_t* sq_norms, int stride, size_t num_rows) {
  const __m256i constant = _mm256_set1_epi32(query.constant);
  return WithAvx2Query(query, stride, [&](const auto& avx2) CAIRN_AVX2 {
    return Avx2NearestTo(avx2, constant, blocks, sq_norms, stride, num_rows);
  });
}

template <typename Query>
CAIRN_AVX2 void Avx2MinimaOfPart(const Query& query, const __m256i& constant, const uint8_t* blocks,
                                 const int32_t* sq_norms, int stride, size_t first, size_t last,
                                 int32_t* minima) {
  __m256i smallest[2];
  smallest[0] = smallest[1] = _mm256_set1_epi32(std::numeric_limits<int32_t>::max());
  for (size_t i = first; i < last; ++i) {
    for (int half = 0; half < 2; ++half) {
      smallest[half] = _mm256_min_epi32(
          smallest[half], Avx2SqDistances(query, constant, blocks + i * kBlockRows * stride,
                                          sq_norms + i * kBlockRows, half));
    }
  }
  for (int half = 0; half < 2; ++half) {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(minima) + half, smallest[half]);
  }
}

CAIRN_AVX2 void Avx2Minima(const BlockQuery& query, const uint8_t* blocks, const int32_t* sq_norms,
                           int stride, size_t num_blocks, size_t num_parts, int32_t* minima) {
  const __m256i constant = _mm256_set1_epi32(query.constant);
  WithAvx2Query(query, stride, [&](const auto& avx2) CAIRN_AVX2 {
    MinimaOfParts(num_blocks, num_parts, minima, [&](size_t first, size_t last, int32_t* smallest) {
      Avx2MinimaOfPart(avx2, constant, blocks, sq_norms, stride, first, last, smallest);
    });
  });
}

// Returns the lanes of the lower or upper rows of a block that are beyond the bound.
// `constant_less_bound` is the query's constant minus the bound.
template <typename Query>
CAIRN_AVX2 inline __m256i Avx2Beyond(const Query& query, __m256i constant_less_bound,
                                     const uint8_t* block, const int32_t* sq_norms, int half) {
  return _mm256_cmpgt_epi32(_mm256_add_epi32(constant_less_bound, Avx2Norms(sq_norms, half)),
                            query.TwiceProducts(block, half));
}

// Returns a bit for each block, of at most kNotedBlocks, that holds a row within the bound.
template <typename Query>
CAIRN_AVX2 inline uint32_t Avx2BlocksWithin(const Query& query, __m256i constant_less_bound,
                                            const uint8_t* blocks, const int32_t* sq_norms,
                                            int stride, size_t num_blocks) {
  constexpr int kAllLanes = 0xff;
  uint32_t noted = 0;
  for (size_t i = 0; i < num_blocks; ++i) {
    const uint8_t* block = blocks + i * kBlockRows * stride;
    const int32_t* norms = sq_norms + i * kBlockRows;
    const __m256i beyond =
        _mm256_and_si256(Avx2Beyond(query, constant_less_bound, block, norms, 0),
                         Avx2Beyond(query, constant_less_bound, block, norms, 1));
    const bool is_noted = _mm256_movemask_ps(_mm256_castsi256_ps(beyond)) != kAllLanes;
    noted |= (is_noted ? uint32_t{1} : 0) << i;
  }
  return noted;
}

// Appends the rows of the block at `row` that are within the bound and in [begin, end).
template <typename Query>
CAIRN_AVX2 inline size_t Avx2Append(const Query& query, __m256i constant, const uint8_t* block,
                                    const int32_t* sq_norms, int32_t max_sq_distance, size_t row,
                                    size_t begin, size_t end, BlockHit* hits) {
  alignas(32) std::array<int32_t, kBlockRows> sq_distances;
  uint32_t beyond = 0;
  for (int half = 0; half < 2; ++half) {
    const __m256i eight = Avx2SqDistances(query, constant, block, sq_norms, half);
    const __m256i is_beyond = _mm256_cmpgt_epi32(eight, _mm256_set1_epi32(max_sq_distance));
    _mm256_store_si256(reinterpret_cast<__m256i*>(sq_distances.data()) + half, eight);
    beyond |= static_cast<uint32_t>(_mm256_movemask_ps(_mm256_castsi256_ps(is_beyond)))
              << half * kBlockRows / 2;
  }
  return AppendHits(RowsInRange(row, begin, end) & ~beyond, row, sq_distances.data(), hits);
}

// Few blocks hold a hit, so a branch for each block would often be mispredicted. The blocks with
// hits are noted without branches, and then computed again.
template <typename Query>
CAIRN_AVX2 size_t Avx2RangeOf(const Query& query, int32_t constant, const uint8_t* blocks,
                              const int32_t* sq_norms, int stride, size_t begin, size_t end,
                              int32_t max_sq_distance, BlockHit* hits) {
  const int64_t constant_less_bound =
      std::max<int64_t>(int64_t{constant} - max_sq_distance, std::numeric_limits<int32_t>::min());
  const __m256i lanes = _mm256_set1_epi32(static_cast<int32_t>(constant_less_bound));
  size_t num_hits = 0;
  for (size_t first = begin / kBlockRows * kBlockRows; first < end;
       first += kNotedBlocks * kBlockRows) {
    const size_t num_blocks = std::min(kNotedBlocks, (end - first + kBlockRows - 1) / kBlockRows);
    uint32_t noted = Avx2BlocksWithin(query, lanes, blocks + first * stride, sq_norms + first,
                                      stride, num_blocks);
    for (; noted != 0; noted &= noted - 1) {
      const size_t row = first + static_cast<size_t>(__builtin_ctz(noted)) * kBlockRows;
      num_hits += Avx2Append(query, _mm256_set1_epi32(constant), blocks + row * stride,
                             sq_norms + row, max_sq_distance, row, begin, end, hits + num_hits);
    }
  }
  return num_hits;
}

CAIRN_AVX2 size_t Avx2Range(const BlockQuery& query, const uint8_t* blocks, const int32_t* sq_norms,
                            int stride, size_t begin, size_t end, int32_t max_sq_distance,
                            BlockHit* hits) {
  return WithAvx2Query(query, stride, [&](const auto& avx2) CAIRN_AVX2 {
    return Avx2RangeOf(avx2, query.constant, blocks, sq_norms, stride, begin, end, max_sq_distance,
                       hits);
  });
}

}  // namespace

const BlockKernels kAvx2BlockKernels = {"avx2", Avx2Scan, Avx2Nearest, Avx2Minima, Avx2Range};

}  // namespace cairn

#endif
