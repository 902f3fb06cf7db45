// Descriptors in blocks, and queries prepared for them; see block_kernels.h.
#ifndef CAIRN_ENGINE_INDEX_BLOCKED_ROWS_H_
#define CAIRN_ENGINE_INDEX_BLOCKED_ROWS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/large_vector.h"
#include "engine/index/block_kernels.h"
#include "engine/index/code_expansion.h"

namespace cairn {

// Working memory of BlockedRows::Nearest.
struct NearestScratch {
  std::vector<int32_t> minima;
  std::vector<BlockHit> hits;
};

class BlockQueries;

// Immutable; safe to use from any thread.
class BlockedRows {
 public:
  // `rows` are row-major with `stride` bytes each (see distance_kernels.h). `order` lists the rows
  // to hold, in order. Distances do not depend on `center`. They are computed fastest if queries
  // have narrow pairs (see BlockQuery): if the bytes of queries lie near `center`.
  BlockedRows(const uint8_t* rows, int stride, std::span<const uint32_t> order,
              uint8_t center = kRowCenter);
  // `codes` are rows of words.num_subspaces() bytes, which are held in the given order.
  BlockedRows(const CodeWords& words, std::span<const uint8_t> codes);
  // `order` lists the rows of codes to hold, in order.
  BlockedRows(const CodeWords& words, std::span<const uint8_t> codes,
              std::span<const uint32_t> order);
  // Holds the codes in the given order; also computes Sum for each run of rows while the rows are
  // in the cache. Run i consists of the rows from run_begin[i] to run_begin[i + 1]. `run_sums`
  // receives stride() numbers per run.
  BlockedRows(const CodeWords& words, std::span<const uint8_t> codes,
              std::span<const uint32_t> run_begin, std::vector<uint32_t>* run_sums);

  size_t size() const { return size_; }
  size_t padded_size() const { return sq_norms_.size(); }  // Whole blocks.
  int stride() const { return stride_; }
  std::span<const int16_t> centers() const { return centers_; }

  // Computes the squared distances to all rows. `sq_distances` must have room for padded_size().
  void Scan(const BlockQuery& query, int32_t* sq_distances) const {
    ScanWith(BestBlockKernels(), query, sq_distances);
  }
  // The same for the queries from `begin` to `end`: `sq_distances` receives padded_size() numbers a
  // query. Rows are read from the level 1 cache by all queries but the first.
  void Scan(const BlockQueries& queries, size_t begin, size_t end, int32_t* sq_distances) const;
  // Returns the first of the nearest rows. There must be at least one row.
  size_t Nearest(const BlockQuery& query) const { return NearestWith(BestBlockKernels(), query); }
  // Appends the `count` nearest rows to `nearest`, in no particular order; among equally near rows,
  // the first. count <= size().
  void Nearest(const BlockQuery& query, size_t count, NearestScratch* scratch,
               std::vector<BlockHit>* nearest) const;
  // See BlockKernels::range.
  size_t Range(const BlockQuery& query, size_t begin, size_t end, int32_t max_sq_distance,
               BlockHit* hits) const {
    return RangeWith(BestBlockKernels(), query, begin, end, max_sq_distance, hits);
  }

  // Like the methods above, with a given variant of the kernels.
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

  // Prefetches a row's block.
  void Prefetch(size_t row) const {
    const uint8_t* block = blocks_.data() + row / kBlockRows * kBlockRows * stride_;
    for (int i = 0; i < kBlockRows * stride_; i += kCacheLineBytes) {
      __builtin_prefetch(block + i);
    }
    __builtin_prefetch(sq_norms_.data() + row);
  }

  // Computes the sum of each dimension over the rows in [begin, end): stride() numbers.
  void Sum(size_t begin, size_t end, uint32_t* sums) const;

  size_t MemoryBytes() const { return blocks_.capacity() + sq_norms_.capacity() * sizeof(int32_t); }

 private:
  static constexpr int kCacheLineBytes = 64;

  // Allocates `size` rows; only the padding is filled.
  BlockedRows(const CodeWords& words, size_t size);
  // Fills the rows from `begin` on, the first row of a block.
  void Expand(const CodeWords& words, std::span<const uint8_t> codes, size_t begin);

  size_t size_;
  int stride_;
  std::vector<int16_t> centers_;  // The same for all rows and dimensions.
  // Aligned so that no group of a block crosses a cache line.
  LargeVector<uint8_t> blocks_;    // The last block is padded.
  LargeVector<int32_t> sq_norms_;  // About the centers, for whole blocks; large for padding rows.
};

// Queries in the form that the kernels take. Immutable; safe to use from any thread.
class BlockQueries {
 public:
  // `steps` holds n x stride values from ByteScale; `centers` are those of the rows.
  BlockQueries(std::span<const int16_t> steps, std::span<const int16_t> centers);
  // Not copyable: queries point into the object's memory.
  BlockQueries(const BlockQueries&) = delete;
  BlockQueries& operator=(const BlockQueries&) = delete;

  const BlockQuery& operator[](size_t query) const { return queries_[query]; }
  size_t size() const { return queries_.size(); }

 private:
  // Splits values into parts that add up to them, and appends the parts. Returns the number of
  // parts.
  int AppendParts(std::span<const int16_t> values);

  size_t stride_;
  std::vector<int16_t> values_;  // n x stride.
  std::vector<int8_t> parts_;    // The parts of all queries, one query after the other.
  std::vector<BlockQuery> queries_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_BLOCKED_ROWS_H_
