#include "engine/index/blocked_rows.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "core/simd.h"
#include "engine/index/distance_kernels.h"
#include "storage/tile/tile_lists.h"

namespace cairn {
namespace {

constexpr int32_t kFarAway = 1 << 30;
// Rows of 16 bytes each, which fill a part of a level 2 cache; whole blocks.
constexpr size_t kRowsInCache = 4096;
// Bytes of rows that fill half of a level 1 cache; several queries are compared with them in
// turn.
constexpr size_t kScannedBytes = 16384;

size_t PaddedSize(size_t num_rows) { return (num_rows + kBlockRows - 1) / kBlockRows * kBlockRows; }

// A 32-bit mask for each row of a block.
using RowMasks = std::array<uint32_t, kBlockRows>;

// For each row of a block, all bits set if the row lies in [begin, end), else none.
RowMasks MaskOfRows(size_t begin, size_t end, size_t block) {
  RowMasks mask;
  for (size_t i = 0; i < kBlockRows; ++i) {
    const size_t row = block * kBlockRows + i;
    mask[i] = row >= begin && row < end ? ~uint32_t{0} : 0;
  }
  return mask;
}

// Consecutive blocks, with masks of the wanted rows in the first and the last block.
struct BlockRun {
  size_t num_blocks;  // At most 257, so that a sum of bytes fits 16 bits.
  RowMasks first_mask;
  RowMasks last_mask;
};

// Adds each dimension of a group to its sum. `bytes` is the start of the group in the first block.
CAIRN_VECTOR_CLONES void AddGroup(const BlockRun& run, const uint8_t* bytes, size_t block_size,
                                  uint32_t* sums) {
  constexpr uint32_t kEvenBytes = 0x00ff00ff, kLowHalf = 0x0000ffff;
  constexpr int kLanes = 8;
  using Words = Lanes<uint32_t, kLanes>;
  for (int row = 0; row < kBlockRows; row += kLanes) {
    Words even = {}, odd = {};  // Two 16-bit sums per lane.
    const auto add = [&](size_t block, const RowMasks* mask) {
      Words words;
      std::memcpy(&words, bytes + block * block_size + row * sizeof(uint32_t), sizeof(words));
      if (mask != nullptr) {
        Words wanted;
        std::memcpy(&wanted, mask->data() + row, sizeof(wanted));
        words &= wanted;
      }
      even += words & kEvenBytes;
      odd += (words >> 8) & kEvenBytes;
    };
    add(0, &run.first_mask);
    for (size_t block = 1; block + 1 < run.num_blocks; ++block) {
      add(block, nullptr);
    }
    if (run.num_blocks > 1) {
      add(run.num_blocks - 1, &run.last_mask);
    }
    const Words by_dim[kGroupDims] = {even & kLowHalf, odd & kLowHalf, even >> 16, odd >> 16};
    for (int dim = 0; dim < kGroupDims; ++dim) {
      for (int lane = 0; lane < kLanes; ++lane) {
        sums[dim] += by_dim[dim][lane];
      }
    }
  }
}

// Copies the groups of a row to their places in its block and returns |row - center|^2. A constant
// stride lets the loops unroll; kStride 0 stands for any stride.
template <int kStride>
int32_t CopyRow(const uint8_t* row, int any_stride, uint8_t center, uint8_t* to) {
  const int stride = kStride > 0 ? kStride : any_stride;
  for (int begin = 0; begin < stride; begin += kGroupDims) {
    std::memcpy(to + begin * kBlockRows, row + begin, kGroupDims);
  }
  int32_t sq_norm = 0;
  for (int dim = 0; dim < stride; ++dim) {
    const int32_t centered = row[dim] - center;
    sq_norm += centered * centered;
  }
  return sq_norm;
}

// See BlockQuery.
bool HasNarrowPairs(std::span<const int16_t> values) {
  // Products of this sum with any byte fit 16 bits.
  constexpr int kMaxSum = std::numeric_limits<int8_t>::max();
  bool is_narrow = true;
  for (size_t dim = 0; dim < values.size(); dim += 2) {
    const int a = values[dim], b = values[dim + 1];
    is_narrow &= std::max(a, 0) + std::max(b, 0) <= kMaxSum;
    is_narrow &= std::min(a, 0) + std::min(b, 0) >= -kMaxSum;
  }
  return is_narrow;
}

// Returns the count-th smallest of few values. Compares each value with all others, which needs no
// branches that depend on the values.
CAIRN_VECTOR_CLONES int32_t SmallestOfFew(size_t count, const int32_t* values, int num_values) {
  int32_t smallest = std::numeric_limits<int32_t>::max();
  for (int i = 0; i < num_values; ++i) {
    int num_up_to = 0;
    for (int j = 0; j < num_values; ++j) {
      num_up_to += static_cast<int>(values[j] <= values[i]);
    }
    const bool is_enough = static_cast<size_t>(num_up_to) >= count;
    smallest = std::min(smallest, is_enough ? values[i] : smallest);
  }
  return smallest;
}

// Returns the count-th smallest value; may reorder the values.
int32_t Smallest(size_t count, std::vector<int32_t>* values) {
  constexpr size_t kMaxFew = 64;
  if (values->size() <= kMaxFew) {
    return SmallestOfFew(count, values->data(), static_cast<int>(values->size()));
  }
  const auto nth = values->begin() + static_cast<ptrdiff_t>(count - 1);
  std::nth_element(values->begin(), nth, values->end());
  return *nth;
}

}  // namespace

BlockedRows::BlockedRows(const uint8_t* rows, int stride, std::span<const uint32_t> order,
                         uint8_t center)
    : size_(order.size()), stride_(stride), centers_(stride, center) {
  constexpr size_t kAhead = 16;  // Number of rows that are prefetched.
  blocks_.assign(PaddedSize(size_) * stride, 0);
  sq_norms_.assign(PaddedSize(size_), kFarAway);
  const auto copy = stride == kDistanceBlock ? CopyRow<kDistanceBlock> : CopyRow<0>;
  for (size_t i = 0; i < size_; ++i) {
    __builtin_prefetch(rows + size_t{order[std::min(i + kAhead, size_ - 1)]} * stride);
    uint8_t* to =
        blocks_.data() + i / kBlockRows * kBlockRows * stride + i % kBlockRows * kGroupDims;
    sq_norms_[i] = copy(rows + size_t{order[i]} * stride, stride, center, to);
  }
}

BlockedRows::BlockedRows(const CodeWords& words, size_t size)
    : size_(size),
      stride_(words.stride()),
      centers_(stride_, kRowCenter),
      blocks_(PaddedSize(size_) * stride_),
      sq_norms_(PaddedSize(size_)) {
  std::fill(sq_norms_.begin() + static_cast<ptrdiff_t>(size_), sq_norms_.end(), kFarAway);
}

void BlockedRows::Expand(const CodeWords& words, std::span<const uint8_t> codes, size_t begin) {
  BestExpansionKernel().expand(words, codes.data(), codes.size() / words.num_subspaces(),
                               blocks_.data() + begin * stride_, sq_norms_.data() + begin);
}

BlockedRows::BlockedRows(const CodeWords& words, std::span<const uint8_t> codes)
    : BlockedRows(words, codes, {}, nullptr) {}

BlockedRows::BlockedRows(const CodeWords& words, std::span<const uint8_t> codes,
                         std::span<const uint32_t> order)
    : BlockedRows(words, order.size()) {
  const size_t code_size = words.num_subspaces();
  std::vector<uint8_t> gathered(std::min(kRowsInCache, size_) * code_size);
  for (size_t begin = 0; begin < size_; begin += kRowsInCache) {
    const size_t count = std::min(kRowsInCache, size_ - begin);
    GatherRows(codes, code_size, order.subspan(begin, count), gathered.data());
    Expand(words, {gathered.data(), count * code_size}, begin);
  }
}

BlockedRows::BlockedRows(const CodeWords& words, std::span<const uint8_t> codes,
                         std::span<const uint32_t> run_begin, std::vector<uint32_t>* run_sums)
    : BlockedRows(words, codes.size() / words.num_subspaces()) {
  const size_t code_size = words.num_subspaces();
  const size_t num_runs = run_begin.empty() ? 0 : run_begin.size() - 1;
  if (num_runs > 0) {
    run_sums->resize(num_runs * stride_);
  }
  size_t run = 0;
  for (size_t begin = 0; begin < size_; begin += kRowsInCache) {
    const size_t end = std::min(size_, begin + kRowsInCache);
    Expand(words, codes.subspan(begin * code_size, (end - begin) * code_size), begin);
    for (; run < num_runs && run_begin[run + 1] <= end; ++run) {
      Sum(run_begin[run], run_begin[run + 1], run_sums->data() + run * stride_);
    }
  }
}

void BlockedRows::Scan(const BlockQueries& queries, size_t begin, size_t end,
                       int32_t* sq_distances) const {
  const BlockKernels& kernels = BestBlockKernels();
  const size_t num_blocks = padded_size() / kBlockRows, block_size = size_t{kBlockRows} * stride_;
  const size_t step = std::max<size_t>(1, kScannedBytes / block_size);
  for (size_t block = 0; block < num_blocks; block += step) {
    const size_t row = block * kBlockRows;
    for (size_t query = begin; query < end; ++query) {
      kernels.scan(queries[query], blocks_.data() + block * block_size, sq_norms_.data() + row,
                   stride_, std::min(step, num_blocks - block),
                   sq_distances + (query - begin) * padded_size() + row);
    }
  }
}

void BlockedRows::Sum(size_t begin, size_t end, uint32_t* sums) const {
  constexpr size_t kMaxRows = size_t{256} * kBlockRows;  // In at most 257 blocks.
  const size_t block_size = size_t{kBlockRows} * stride_;
  std::fill_n(sums, stride_, 0u);
  for (; begin < end; begin += std::min(kMaxRows, end - begin)) {
    const size_t stop = std::min(end, begin + kMaxRows);
    const size_t first = begin / kBlockRows, last = (stop - 1) / kBlockRows;
    const BlockRun run = {.num_blocks = last - first + 1,
                          .first_mask = MaskOfRows(begin, stop, first),
                          .last_mask = MaskOfRows(begin, stop, last)};
    for (int dim = 0; dim < stride_; dim += kGroupDims) {
      AddGroup(run, blocks_.data() + first * block_size + dim * kBlockRows, block_size, sums + dim);
    }
  }
}

// Each minimum is the distance of a different row, so at least `count` rows are within the count-th
// smallest minimum. With twice as many minima as requested rows, few other rows are within this
// bound.
void BlockedRows::Nearest(const BlockQuery& query, size_t count, NearestScratch* scratch,
                          std::vector<BlockHit>* nearest) const {
  if (count == 0) {
    return;
  }
  const size_t num_blocks = padded_size() / kBlockRows;
  const size_t num_parts = std::min(num_blocks, (2 * count + kBlockRows - 1) / kBlockRows);
  scratch->minima.resize(num_parts * kBlockRows);
  MinimaWith(BestBlockKernels(), query, num_parts, scratch->minima.data());
  const int32_t bound = Smallest(count, &scratch->minima);
  std::vector<BlockHit>& hits = scratch->hits;
  hits.resize(size_ + kRangeSlack);
  const auto end =
      hits.begin() + static_cast<ptrdiff_t>(Range(query, 0, size_, bound, hits.data()));
  const auto last = hits.begin() + static_cast<ptrdiff_t>(count);
  std::nth_element(hits.begin(), last - 1, end, [](const BlockHit& a, const BlockHit& b) {
    return a.sq_distance != b.sq_distance ? a.sq_distance < b.sq_distance : a.row < b.row;
  });
  nearest->insert(nearest->end(), hits.begin(), last);
}

BlockQueries::BlockQueries(std::span<const int16_t> steps, std::span<const int16_t> centers)
    : stride_(centers.size()), values_(steps.size()), queries_(steps.size() / stride_) {
  parts_.reserve(steps.size());
  std::vector<int16_t> values(stride_);
  for (size_t i = 0; i < queries_.size(); ++i) {
    BlockQuery& query = queries_[i];
    for (size_t dim = 0; dim < stride_; ++dim) {
      values[dim] = static_cast<int16_t>(steps[i * stride_ + dim] - centers[dim]);
      query.constant += values[dim] * (values[dim] + 2 * centers[dim]);
    }
    query.num_parts = AppendParts(values);
    query.has_narrow_pairs = HasNarrowPairs(values);
    int16_t* ordered = values_.data() + i * stride_;
    for (size_t group = 0; group < stride_; group += kGroupDims) {
      for (int j = 0; j < kGroupDims; ++j) {
        ordered[group + j] = values[group + kDimOfValue[j]];
      }
    }
    query.values = ordered;
  }
  const int8_t* parts = parts_.data();
  for (BlockQuery& query : queries_) {
    query.parts = parts;
    parts += query.num_parts * stride_;
  }
}

int BlockQueries::AppendParts(std::span<const int16_t> values) {
  constexpr int16_t kMinPart = std::numeric_limits<int8_t>::min();
  constexpr int16_t kMaxPart = std::numeric_limits<int8_t>::max();
  // What the previous parts leave of the values; not used for the first part.
  std::vector<int16_t> rest;
  for (int num_parts = 1;; ++num_parts) {
    int16_t unequal = 0;
    const size_t begin = parts_.size();
    parts_.resize(begin + stride_);
    for (size_t dim = 0; dim < stride_; ++dim) {
      const int16_t value = num_parts == 1 ? values[dim] : rest[dim];
      const int16_t part = std::clamp(value, kMinPart, kMaxPart);
      parts_[begin + dim] = static_cast<int8_t>(part);
      unequal = static_cast<int16_t>(unequal | (value ^ part));
    }
    if (unequal == 0) {
      return num_parts;
    }
    rest.resize(stride_);
    for (size_t dim = 0; dim < stride_; ++dim) {
      rest[dim] =
          static_cast<int16_t>((num_parts == 1 ? values[dim] : rest[dim]) - parts_[begin + dim]);
    }
  }
}

}  // namespace cairn
