// Squared distances between a query and descriptors that lie in blocks of 16, dimension by
// dimension: four times as many a second as of rows that lie one by one, where whole runs of rows
// are wanted.
#ifndef CAIRN_ENGINE_INDEX_KERNELS_BLOCK_KERNELS_H_
#define CAIRN_ENGINE_INDEX_KERNELS_BLOCK_KERNELS_H_

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cairn {

// A block holds kBlockRows rows of `stride` bytes (as distance_kernels.h) in groups of
// kGroupDims dimensions: byte (group * kBlockRows + row) * kGroupDims + j is dimension
// group * kGroupDims + j of the row. With rows r and query q about the same centers c,
//   |q - r|^2 = |q - c|^2 + |r - c|^2 - 2 (q - c).(r - c),
// of which the last term is, up to a constant of the query, a product of the query's centered
// values with the bytes as they are.
inline constexpr int kBlockRows = 16;
inline constexpr int kGroupDims = 4;

// A query prepared for the kernels.
struct BlockQuery {
  const int16_t* values = nullptr;  // `stride` of them: q - c.
  const int8_t* parts = nullptr;    // num_parts x stride: summands of the values that fit a byte.
  int num_parts = 0;                // 1 unless the query is far outside of the descriptors.
  int32_t constant = 0;             // |q - c|^2 + 2 (q - c).c.
  // There is one part, and two neighbouring values times any two bytes add up to 16 bits.
  bool has_narrow_pairs = false;
};

struct BlockHit {
  uint32_t row = 0;
  int32_t sq_distance = 0;
};

inline constexpr size_t kRangeSlack = kBlockRows;

// Results are integers, so every variant gives the same.
struct BlockKernels {
  const char* name;  // "plain", "avx2", "avx512vnni".

  // Squared distances to the rows of `num_blocks` blocks. sq_norms: |r - c|^2 of each row.
  void (*scan)(const BlockQuery& query, const uint8_t* blocks, const int32_t* sq_norms, int stride,
               size_t num_blocks, int32_t* sq_distances);

  // The first of the `num_rows` > 0 rows with the smallest squared distance. Padding rows must be
  // farther than all others.
  size_t (*nearest)(const BlockQuery& query, const uint8_t* blocks, const int32_t* sq_norms,
                    int stride, size_t num_rows);

  // The smallest squared distance at each place of a block, over each of `num_parts` equal parts of
  // the blocks: num_parts x kBlockRows, the largest number for a part without blocks.
  void (*minima)(const BlockQuery& query, const uint8_t* blocks, const int32_t* sq_norms,
                 int stride, size_t num_blocks, size_t num_parts, int32_t* minima);

  // Rows in [begin, end) with a squared distance of at most `max_sq_distance`, in order; returns
  // their number. `hits` has room for all rows of the range and kRangeSlack more, which may be
  // written.
  size_t (*range)(const BlockQuery& query, const uint8_t* blocks, const int32_t* sq_norms,
                  int stride, size_t begin, size_t end, int32_t max_sq_distance, BlockHit* hits);
};

// The fastest variant this processor runs.
const BlockKernels& BestBlockKernels();

// Every variant this processor runs, the portable one first. For tests and benchmarks.
std::vector<const BlockKernels*> SupportedBlockKernels();

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_KERNELS_BLOCK_KERNELS_H_
