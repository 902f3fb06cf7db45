#include "engine/matching/block_kernels.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#if defined(__x86_64__)
// See distance_kernels.cc.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wuninitialized"
#include <immintrin.h>
#endif

namespace cairn {
namespace {

// One block: products of the query's values with the bytes, per row.
void PlainProducts(const BlockQuery& query, const uint8_t* block, int stride, int32_t* products) {
  std::fill_n(products, kBlockRows, 0);
  for (int begin = 0; begin < stride; begin += kGroupDims) {
    for (int row = 0; row < kBlockRows; ++row) {
      for (int j = 0; j < kGroupDims; ++j) {
        products[row] += query.values[begin + j] * *block++;
      }
    }
  }
}

void PlainBlock(const BlockQuery& query, const uint8_t* block, const int32_t* sq_norms, int stride,
                int32_t* sq_distances) {
  int32_t products[kBlockRows];
  PlainProducts(query, block, stride, products);
  for (int row = 0; row < kBlockRows; ++row) {
    sq_distances[row] = query.constant + sq_norms[row] - 2 * products[row];
  }
}

void PlainScan(const BlockQuery& query, const uint8_t* blocks, const int32_t* sq_norms, int stride,
               size_t num_blocks, int32_t* sq_distances) {
  for (size_t i = 0; i < num_blocks; ++i) {
    PlainBlock(query, blocks + i * kBlockRows * stride, sq_norms + i * kBlockRows, stride,
               sq_distances + i * kBlockRows);
  }
}

// The smallest of `candidates` by distance, then row.
size_t NearestOf(const BlockHit* candidates, int count) {
  const BlockHit* nearest =
      std::min_element(candidates, candidates + count, [](const BlockHit& a, const BlockHit& b) {
        return a.sq_distance != b.sq_distance ? a.sq_distance < b.sq_distance : a.row < b.row;
      });
  return nearest->row;
}

size_t PlainNearest(const BlockQuery& query, const uint8_t* blocks, const int32_t* sq_norms,
                    int stride, size_t num_rows) {
  BlockHit nearest = {0, std::numeric_limits<int32_t>::max()};
  int32_t sq_distances[kBlockRows];
  for (size_t first = 0; first < num_rows; first += kBlockRows) {
    PlainBlock(query, blocks + first * stride, sq_norms + first, stride, sq_distances);
    for (int row = 0; row < kBlockRows; ++row) {
      if (sq_distances[row] < nearest.sq_distance) {
        nearest = {static_cast<uint32_t>(first) + row, sq_distances[row]};
      }
    }
  }
  return nearest.row;
}

// Calls reduce(first, last, minima) for each part of the blocks.
template <typename ReducePart>
inline void MinimaOfParts(size_t num_blocks, size_t num_parts, int32_t* minima,
                          const ReducePart& reduce) {
  for (size_t part = 0; part < num_parts; ++part) {
    reduce(part * num_blocks / num_parts, (part + 1) * num_blocks / num_parts,
           minima + part * kBlockRows);
  }
}

void PlainMinima(const BlockQuery& query, const uint8_t* blocks, const int32_t* sq_norms,
                 int stride, size_t num_blocks, size_t num_parts, int32_t* minima) {
  MinimaOfParts(num_blocks, num_parts, minima, [&](size_t first, size_t last, int32_t* smallest) {
    int32_t sq_distances[kBlockRows];
    std::fill_n(smallest, kBlockRows, std::numeric_limits<int32_t>::max());
    for (size_t i = first; i < last; ++i) {
      PlainBlock(query, blocks + i * kBlockRows * stride, sq_norms + i * kBlockRows, stride,
                 sq_distances);
      for (int row = 0; row < kBlockRows; ++row) {
        smallest[row] = std::min(smallest[row], sq_distances[row]);
      }
    }
  });
}

size_t PlainRange(const BlockQuery& query, const uint8_t* blocks, const int32_t* sq_norms,
                  int stride, size_t begin, size_t end, int32_t max_sq_distance, BlockHit* hits) {
  size_t num_hits = 0;
  int32_t sq_distances[kBlockRows];
  for (size_t first = begin / kBlockRows * kBlockRows; first < end; first += kBlockRows) {
    PlainBlock(query, blocks + first * stride, sq_norms + first, stride, sq_distances);
    const size_t last = std::min(end, first + kBlockRows);
    for (size_t row = std::max(begin, first); row < last; ++row) {
      if (sq_distances[row - first] <= max_sq_distance) {
        hits[num_hits++] = {static_cast<uint32_t>(row), sq_distances[row - first]};
      }
    }
  }
  return num_hits;
}

constexpr BlockKernels kPlain = {"plain", PlainScan, PlainNearest, PlainMinima, PlainRange};

// Bits of the rows of the block at `first` that lie in [begin, end).
inline uint32_t RowsInRange(size_t first, size_t begin, size_t end) {
  uint32_t rows = (uint32_t{1} << kBlockRows) - 1;
  if (first < begin) {
    rows &= rows << (begin - first);
  }
  if (end - first < kBlockRows) {
    rows &= (uint32_t{1} << (end - first)) - 1;
  }
  return rows & ((uint32_t{1} << kBlockRows) - 1);
}

// Appends the rows whose bits are set.
inline size_t AppendHits(uint32_t rows, size_t first, const int32_t* sq_distances, BlockHit* hits) {
  size_t num_hits = 0;
  for (; rows != 0; rows &= rows - 1) {
    const int row = __builtin_ctz(rows);
    hits[num_hits++] = {static_cast<uint32_t>(first) + row, sq_distances[row]};
  }
  return num_hits;
}

#if defined(__x86_64__)

#define CAIRN_AVX2 __attribute__((target("avx2")))
#define CAIRN_AVX512VNNI __attribute__((target("avx512f,avx512bw,avx512vl,avx512vnni")))

// The products of a query with eight rows of a block at a time, of which there are three forms: any
// query,
class Avx2AnyQuery {
 public:
  Avx2AnyQuery(const BlockQuery& query, int stride) : query_(query), stride_(stride) {}

  // Twice the products with the lower (half = 0) or upper rows.
  CAIRN_AVX2 __m256i TwiceProducts(const uint8_t* block, int half) const {
    const auto* bytes = reinterpret_cast<const __m256i*>(block) + half;
    __m256i products = _mm256_setzero_si256();
    for (int group = 0; group < stride_ / kGroupDims; ++group) {
      const int16_t* values = query_.values + group * kGroupDims;
      products = _mm256_add_epi32(products,
                                  Products(bytes[2 * group], Values(values), Values(values + 1)));
    }
    return _mm256_slli_epi32(products, 1);
  }

  // Every second of the four values of a group, from `from` on.
  CAIRN_AVX2 static __m256i Values(const int16_t* from) {
    return _mm256_set1_epi32(static_cast<uint16_t>(from[0]) |
                             static_cast<int32_t>(static_cast<uint32_t>(from[2]) << 16));
  }
  // Of one group: even and odd bytes are multiplied one after the other.
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

constexpr int kNumSmall = 4;  // Groups of a query that stays in registers: rows of 16 bytes.

CAIRN_AVX2 inline __m256i Sum(__m256i a, __m256i b, __m256i c, __m256i d) {
  return _mm256_add_epi32(_mm256_add_epi32(a, b), _mm256_add_epi32(c, d));
}

// a small one,
class Avx2SmallQuery {
 public:
  CAIRN_AVX2 explicit Avx2SmallQuery(const BlockQuery& query) {
    for (int group = 0; group < kNumSmall; ++group) {
      even_[group] = Avx2AnyQuery::Values(query.values + group * kGroupDims);
      odd_[group] = Avx2AnyQuery::Values(query.values + group * kGroupDims + 1);
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
  __m256i even_[kNumSmall], odd_[kNumSmall];
};

// and the usual one: small with narrow pairs, whose bytes are multiplied as they are.
class Avx2NarrowQuery {
 public:
  CAIRN_AVX2 explicit Avx2NarrowQuery(const BlockQuery& query) {
    for (int group = 0; group < kNumSmall; ++group) {
      int32_t four_values;
      std::memcpy(&four_values, query.parts + group * kGroupDims, sizeof(four_values));
      parts_[group] = _mm256_set1_epi32(four_values);
    }
  }
  CAIRN_AVX2 __m256i TwiceProducts(const uint8_t* block, int half) const {
    const auto* bytes = reinterpret_cast<const __m256i*>(block) + half;
    const auto products = [&](int group) CAIRN_AVX2 {
      return _mm256_madd_epi16(
          _mm256_maddubs_epi16(_mm256_loadu_si256(bytes + 2 * group), parts_[group]),
          _mm256_set1_epi16(2));
    };
    return Sum(products(0), products(1), products(2), products(3));
  }

 private:
  __m256i parts_[kNumSmall];
};

// Calls use(q) with q the query in its form.
template <typename Use>
CAIRN_AVX2 inline auto WithAvx2Query(const BlockQuery& query, int stride, const Use& use) {
  if (stride != kNumSmall * kGroupDims) {
    return use(Avx2AnyQuery(query, stride));
  }
  return query.has_narrow_pairs ? use(Avx2NarrowQuery(query)) : use(Avx2SmallQuery(query));
}

CAIRN_AVX2 inline __m256i Avx2Norms(const int32_t* sq_norms, int half) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(sq_norms) + half);
}

// Of the lower (half = 0) or upper eight rows of a block, with the query's constant.
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
  // Of each lane, the first of its nearest rows.
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
CAIRN_AVX2 void Avx2MinimaOfPart(const Query& query, __m256i constant, const uint8_t* blocks,
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

// Lanes of the lower or upper rows of a block that are beyond a bound, which the query's constant
// is given less of.
template <typename Query>
CAIRN_AVX2 inline __m256i Avx2Beyond(const Query& query, __m256i constant_less_bound,
                                     const uint8_t* block, const int32_t* sq_norms, int half) {
  return _mm256_cmpgt_epi32(_mm256_add_epi32(constant_less_bound, Avx2Norms(sq_norms, half)),
                            query.TwiceProducts(block, half));
}

// Blocks with rows within the bound are noted before their hits are appended.
constexpr size_t kNotedBlocks = 32;

// Bits of the blocks that hold a row within the bound, of at most kNotedBlocks.
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

// Few blocks hold a hit, and a branch for each would often be mispredicted: those with hits are
// noted without one, and computed again.
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

// The squared distances of one block after another, the usual case by itself: rows of 16 bytes and
// a query of one part, which stays in registers.
class VnniQuery {
 public:
  CAIRN_AVX512VNNI VnniQuery(const BlockQuery& query, int stride)
      : query_(query),
        stride_(stride),
        is_small_(stride == kNumSmall * kGroupDims && query.num_parts == 1),
        constant_(_mm512_set1_epi32(query.constant)) {
    for (int group = 0; group < kNumSmall; ++group) {
      small_[group] = Values(query.parts + group * kGroupDims);
    }
  }

  CAIRN_AVX512VNNI __m512i SqDistances(const uint8_t* block, const int32_t* sq_norms) const {
    __m512i products = _mm512_setzero_si512();
    if (is_small_) {
      // Two sums, so that one product need not wait for the last.
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
  static constexpr int kNumSmall = 4;

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
  __m512i small_[kNumSmall];  // The first groups.
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
  // Of each lane, the first of its nearest rows.
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

// Appends the `near` rows of one block without a branch. Writes beyond them, up to a whole block.
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

// As Avx2RangeOfFew.
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

constexpr BlockKernels kAvx2 = {"avx2", Avx2Scan, Avx2Nearest, Avx2Minima, Avx2Range};
constexpr BlockKernels kAvx512Vnni = {"avx512vnni", VnniScan, VnniNearest, VnniMinima, VnniRange};

#endif

}  // namespace

const BlockKernels& BestBlockKernels() {
  static const BlockKernels& best = *SupportedBlockKernels().back();
  return best;
}

std::vector<const BlockKernels*> SupportedBlockKernels() {
  std::vector<const BlockKernels*> supported = {&kPlain};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) {
    supported.push_back(&kAvx2);
  }
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512vnni")) {
    supported.push_back(&kAvx512Vnni);
  }
#endif
  return supported;
}

}  // namespace cairn
