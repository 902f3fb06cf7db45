// Descriptors in blocks, and queries prepared for them: see block_kernels.h.
#ifndef CAIRN_ENGINE_INDEX_KERNELS_BLOCKED_ROWS_H_
#define CAIRN_ENGINE_INDEX_KERNELS_BLOCKED_ROWS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/large_vector.h"
#include "engine/index/kernels/block_kernels.h"
#include "engine/index/kernels/code_expansion.h"

namespace cairn {

// Working memory of BlockedRows::Nearest.
struct NearestScratch {
  std::vector<int32_t> minima;
  std::vector<BlockHit> hits;
};

// Immutable; safe to use from any thread.
class BlockedRows {
 public:
  // rows: any number x stride bytes, row-major; `order` lists those to hold, in order. stride as in
  // distance_kernels.h.
  BlockedRows(const uint8_t* rows, int stride, std::span<const uint32_t> order);
  // codes: rows of words.num_subspaces() bytes, to hold in their order.
  BlockedRows(const CodeWords& words, std::span<const uint8_t> codes);
  // The same, and Sum of each run of rows, which it reads while they are in the cache. Run i are
  // the rows from run_begin[i] to run_begin[i + 1]; `run_sums` gets stride() numbers a run.
  BlockedRows(const CodeWords& words, std::span<const uint8_t> codes,
              std::span<const uint32_t> run_begin, std::vector<uint32_t>* run_sums);

  size_t size() const { return size_; }
  size_t padded_size() const { return sq_norms_.size(); }  // Whole blocks.
  int stride() const { return stride_; }
  std::span<const int16_t> centers() const { return centers_; }

  // Squared distances to all rows; there must be room for padded_size().
  void Scan(const BlockQuery& query, int32_t* sq_distances) const {
    ScanWith(BestBlockKernels(), query, sq_distances);
  }
  // The first of the nearest rows; there must be some.
  size_t Nearest(const BlockQuery& query) const { return NearestWith(BestBlockKernels(), query); }
  // Appends the `count` nearest rows to `nearest`, of equally near ones the first, in no particular
  // order; count <= size().
  void Nearest(const BlockQuery& query, size_t count, NearestScratch* scratch,
               std::vector<BlockHit>* nearest) const;
  // See BlockKernels::range.
  size_t Range(const BlockQuery& query, size_t begin, size_t end, int32_t max_sq_distance,
               BlockHit* hits) const {
    return RangeWith(BestBlockKernels(), query, begin, end, max_sq_distance, hits);
  }

  // The same by a variant of the kernels.
  void ScanWith(const BlockKernels& kernels, const BlockQuery& query, int32_t* sq_distances) const {
    kernels.scan(query, blocks_.data(), sq_norms_.data(), stride_, sq_norms_.size() / kBlockRows,
                 sq_distances);
  }
  size_t NearestWith(const BlockKernels& kernels, const BlockQuery& query) const {
    return kernels.nearest(query, blocks_.data(), sq_norms_.data(), stride_, size_);
  }
  void MinimaWith(const BlockKernels& kernels, const BlockQuery& query, size_t num_parts,
                  int32_t* minima) const {
    kernels.minima(query, blocks_.data(), sq_norms_.data(), stride_, sq_norms_.size() / kBlockRows,
                   num_parts, minima);
  }
  size_t RangeWith(const BlockKernels& kernels, const BlockQuery& query, size_t begin, size_t end,
                   int32_t max_sq_distance, BlockHit* hits) const {
    return kernels.range(query, blocks_.data(), sq_norms_.data(), stride_, begin, end,
                         max_sq_distance, hits);
  }

  // Asks the processor to fetch a row's block.
  void Prefetch(size_t row) const {
    const uint8_t* block = blocks_.data() + row / kBlockRows * kBlockRows * stride_;
    for (int i = 0; i < kBlockRows * stride_; i += kCacheLineBytes) {
      __builtin_prefetch(block + i);
    }
    __builtin_prefetch(sq_norms_.data() + row);
  }

  // The sums of each dimension over the rows in [begin, end): stride() numbers.
  void Sum(size_t begin, size_t end, uint32_t* sums) const;

  size_t MemoryBytes() const { return blocks_.capacity() + sq_norms_.capacity() * sizeof(int32_t); }

 private:
  static constexpr int kCacheLineBytes = 64;

  size_t size_;
  int stride_;
  std::vector<int16_t> centers_;  // The same for all rows: the middle of a byte.
  // No group of a block lies across two cache lines.
  LargeVector<uint8_t> blocks_;    // The last one is padded.
  LargeVector<int32_t> sq_norms_;  // About the centers, of whole blocks; large in the padding.
};

// Queries in the form of the kernels. Immutable; safe to use from any thread.
class BlockQueries {
 public:
  // steps: n x stride values as ByteScale makes them; `centers` those of the rows.
  BlockQueries(std::span<const int16_t> steps, std::span<const int16_t> centers);
  BlockQueries(const BlockQueries&) = delete;  // Queries point into their own memory.
  BlockQueries& operator=(const BlockQueries&) = delete;

  const BlockQuery& operator[](size_t query) const { return queries_[query]; }
  size_t size() const { return queries_.size(); }

 private:
  // Appends values as a sum of parts; returns their number.
  int AppendParts(std::span<const int16_t> values);

  size_t stride_;
  std::vector<int16_t> values_;  // n x stride.
  std::vector<int8_t> parts_;    // Of one query after the other.
  std::vector<BlockQuery> queries_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_KERNELS_BLOCKED_ROWS_H_
