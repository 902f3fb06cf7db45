// Squared distances between a query and descriptors in blocks of 16, stored dimension by dimension.
// For runs of consecutive rows, this layout gives four times as many distances per second as rows
// stored one after the other.
#ifndef CAIRN_ENGINE_INDEX_BLOCK_KERNELS_H_
#define CAIRN_ENGINE_INDEX_BLOCK_KERNELS_H_

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cairn {

// A block holds kBlockRows rows of `stride` bytes (see distance_kernels.h) in groups of kGroupDims
// dimensions. Byte (group * kBlockRows + row) * kGroupDims + j is dimension group * kGroupDims + j
// of the row. For rows r, a query q and the common centers c,
//   |q - r|^2 = |q - c|^2 + |r - c|^2 - 2 (q - c).(r - c).
// The last term is a constant of the query plus a product of the query's centered values q - c with
// the bytes as stored.
inline constexpr int kBlockRows = 16;
inline constexpr int kGroupDims = 4;
// The order of a group's dimensions in BlockQuery::values: two that lie 16 bits apart among the
// bytes of a row are multiplied at once.
inline constexpr int kDimOfValue[kGroupDims] = {0, 2, 1, 3};

// A query prepared for the kernels.
struct BlockQuery {
  const int16_t* values = nullptr;  // q - c, `stride` values; each group in the order kDimOfValue.
  const int8_t* parts = nullptr;    // num_parts x stride bytes whose sum over the parts is q - c.
  int num_parts = 0;     // 1 unless the query is far outside the range of the descriptors.
  int32_t constant = 0;  // |q - c|^2 + 2 (q - c).c.
  // True if num_parts is 1 and the products of two neighboring values with any two bytes add up to
  // 16 bits.
  bool has_narrow_pairs = false;
};

struct BlockHit {
  uint32_t row = 0;
  int32_t sq_distance = 0;
};

inline constexpr size_t kRangeSlack = kBlockRows;

// Results are integers, so every variant returns the same.
struct BlockKernels {
  const char* name;  // "plain", "avx2", "avx512vnni".

  // Computes the squared distances to the rows of `num_blocks` blocks. sq_norms: |r - c|^2 of each
  // row.
  void (*scan)(const BlockQuery& query, const uint8_t* blocks, const int32_t* sq_norms, int stride,
               size_t num_blocks, int32_t* sq_distances);

  // Returns the first row with the smallest squared distance among `num_rows` > 0 rows. Padding
  // rows must be farther than all others.
  size_t (*nearest)(const BlockQuery& query, const uint8_t* blocks, const int32_t* sq_norms,
                    int stride, size_t num_rows);

  // Splits the blocks into `num_parts` equal parts. For each part and each position within a block,
  // computes the smallest squared distance: num_parts x kBlockRows values, the largest number for a
  // part without blocks.
  void (*minima)(const BlockQuery& query, const uint8_t* blocks, const int32_t* sq_norms,
                 int stride, size_t num_blocks, size_t num_parts, int32_t* minima);

  // Finds the rows in [begin, end) with a squared distance of at most `max_sq_distance`, in order,
  // and returns their number. `hits` must have room for all rows of the range and kRangeSlack more;
  // the extra room may be overwritten.
  size_t (*range)(const BlockQuery& query, const uint8_t* blocks, const int32_t* sq_norms,
                  int stride, size_t begin, size_t end, int32_t max_sq_distance, BlockHit* hits);
};

// Returns the fastest variant that this processor supports.
const BlockKernels& BestBlockKernels();

// Returns every variant that this processor supports, the portable one first. For tests and
// benchmarks.
std::vector<const BlockKernels*> SupportedBlockKernels();

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_BLOCK_KERNELS_H_
