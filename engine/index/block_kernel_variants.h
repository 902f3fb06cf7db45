// Shared by the variants of the block kernels. Private to block_kernels*.cc.
#ifndef CAIRN_ENGINE_INDEX_BLOCK_KERNEL_VARIANTS_H_
#define CAIRN_ENGINE_INDEX_BLOCK_KERNEL_VARIANTS_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "engine/index/block_kernels.h"

namespace cairn {

#if defined(__x86_64__)
// Only for processors that support the instructions in the names.
extern const BlockKernels kAvx2BlockKernels;
extern const BlockKernels kAvx512VnniBlockKernels;

// Number of groups of a query that fits registers: rows of 16 bytes.
inline constexpr int kNumSmallGroups = 4;
// Blocks with rows within the bound are noted before their hits are appended.
inline constexpr size_t kNotedBlocks = 32;
#endif

// Returns the row of the smallest candidate by distance, then row.
inline size_t NearestOf(const BlockHit* candidates, int count) {
  const BlockHit* nearest =
      std::min_element(candidates, candidates + count, [](const BlockHit& a, const BlockHit& b) {
        return a.sq_distance != b.sq_distance ? a.sq_distance < b.sq_distance : a.row < b.row;
      });
  return nearest->row;
}

// Splits the blocks into parts and calls reduce(first, last, minima) for each.
template <typename ReducePart>
void MinimaOfParts(size_t num_blocks, size_t num_parts, int32_t* minima, const ReducePart& reduce) {
  for (size_t part = 0; part < num_parts; ++part) {
    reduce(part * num_blocks / num_parts, (part + 1) * num_blocks / num_parts,
           minima + part * kBlockRows);
  }
}

// Returns a bit for each row of the block at `first` that lies in [begin, end).
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

// Appends the rows whose bits are set. Returns their number.
inline size_t AppendHits(uint32_t rows, size_t first, const int32_t* sq_distances, BlockHit* hits) {
  size_t num_hits = 0;
  for (; rows != 0; rows &= rows - 1) {
    const int row = __builtin_ctz(rows);
    hits[num_hits++] = {static_cast<uint32_t>(first) + row, sq_distances[row]};
  }
  return num_hits;
}

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_BLOCK_KERNEL_VARIANTS_H_
