#include "engine/matching/blocked_rows.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "engine/matching/distance_kernels.h"
#include "engine/vector_clones.h"

namespace cairn {
namespace {

constexpr int16_t kCenter = 128;  // Queries within the bytes' range then need one part.

constexpr int32_t kFarAway = 1 << 30;

size_t PaddedSize(size_t num_rows) { return (num_rows + kBlockRows - 1) / kBlockRows * kBlockRows; }

constexpr int kNumGroups = kDistanceBlock / kGroupDims;  // Of a block that are added together.

// Adds up kDistanceBlock dimensions of whole blocks, which begin at `bytes` in the first one: adds
// to as many sums. At most 257 blocks, so that a sum of bytes fits 16 bits.
CAIRN_VECTOR_CLONES void AddBlocks(const uint8_t* bytes, size_t block_size, size_t num_blocks,
                                   uint32_t* sums) {
  constexpr uint32_t kEvenBytes = 0x00ff00ff;
  using Words = uint32_t __attribute__((vector_size(kBlockRows * kGroupDims)));  // A row each.
  Words even[kNumGroups] = {}, odd[kNumGroups] = {};  // Two sums of 16 bits each.
  for (size_t i = 0; i < num_blocks; ++i, bytes += block_size) {
    for (int group = 0; group < kNumGroups; ++group) {
      Words words;
      std::memcpy(&words, bytes + group * sizeof(words), sizeof(words));
      even[group] += words & kEvenBytes;
      odd[group] += (words >> 8) & kEvenBytes;
    }
  }
  for (int group = 0; group < kNumGroups; ++group, sums += kGroupDims) {
    std::array<uint32_t, kBlockRows> even_sums, odd_sums;
    std::memcpy(even_sums.data(), &even[group], sizeof(even_sums));
    std::memcpy(odd_sums.data(), &odd[group], sizeof(odd_sums));
    for (int row = 0; row < kBlockRows; ++row) {
      sums[0] += even_sums[row] & 0xffff;
      sums[1] += odd_sums[row] & 0xffff;
      sums[2] += even_sums[row] >> 16;
      sums[3] += odd_sums[row] >> 16;
    }
  }
}

// The same of `num_rows` rows of a block.
void AddRows(const uint8_t* bytes, size_t num_rows, uint32_t* sums) {
  for (int group = 0; group < kNumGroups; ++group, sums += kGroupDims) {
    const uint8_t* row = bytes + group * kBlockRows * kGroupDims;
    for (size_t i = 0; i < num_rows * kGroupDims; ++i) {
      sums[i % kGroupDims] += row[i];
    }
  }
}

// Copies the groups of a row to their places in its block, and returns |row - center|^2. The
// constant stride lets the loops unroll; kStride 0 stands for any.
template <int kStride>
int32_t CopyRow(const uint8_t* row, int any_stride, uint8_t* to) {
  const int stride = kStride > 0 ? kStride : any_stride;
  for (int begin = 0; begin < stride; begin += kGroupDims) {
    std::memcpy(to + begin * kBlockRows, row + begin, kGroupDims);
  }
  int32_t sq_norm = 0;
  for (int dim = 0; dim < stride; ++dim) {
    const int32_t centered = row[dim] - kCenter;
    sq_norm += centered * centered;
  }
  return sq_norm;
}

// See BlockQuery.
bool HasNarrowPairs(std::span<const int16_t> values) {
  constexpr int kMaxSum = std::numeric_limits<int8_t>::max();  // Times any byte fits 16 bits.
  bool is_narrow = true;
  for (size_t dim = 0; dim < values.size(); dim += 2) {
    const int a = values[dim], b = values[dim + 1];
    is_narrow &= std::max(a, 0) + std::max(b, 0) <= kMaxSum;
    is_narrow &= std::min(a, 0) + std::min(b, 0) >= -kMaxSum;
  }
  return is_narrow;
}

// The count-th smallest of few values. Comparing each with all others takes no branches that depend
// on them.
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

// The count-th smallest value; may change their order.
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

BlockedRows::BlockedRows(const uint8_t* rows, int stride, std::span<const uint32_t> order)
    : size_(order.size()), stride_(stride), centers_(stride, kCenter) {
  constexpr size_t kAhead = 16;  // Rows that are asked for ahead.
  blocks_.assign(PaddedSize(size_) * stride, 0);
  sq_norms_.assign(PaddedSize(size_), kFarAway);
  const auto copy = stride == kDistanceBlock ? CopyRow<kDistanceBlock> : CopyRow<0>;
  for (size_t i = 0; i < size_; ++i) {
    __builtin_prefetch(rows + size_t{order[std::min(i + kAhead, size_ - 1)]} * stride);
    uint8_t* to =
        blocks_.data() + i / kBlockRows * kBlockRows * stride + i % kBlockRows * kGroupDims;
    sq_norms_[i] = copy(rows + size_t{order[i]} * stride, stride, to);
  }
}

BlockedRows::BlockedRows(const CodeWords& words, std::span<const uint8_t> codes)
    : size_(codes.size() / words.num_subspaces()),
      stride_(words.stride()),
      centers_(stride_, kCenter),
      blocks_(PaddedSize(size_) * stride_),
      sq_norms_(PaddedSize(size_)) {
  BestExpansionKernel().expand(words, kCenter, codes.data(), size_, blocks_.data(),
                               sq_norms_.data());
  std::fill(sq_norms_.begin() + static_cast<ptrdiff_t>(size_), sq_norms_.end(), kFarAway);
}

void BlockedRows::Sum(size_t begin, size_t end, uint32_t* sums) const {
  constexpr size_t kMaxBlocks = 257;  // See AddBlocks.
  const size_t block_size = size_t{kBlockRows} * stride_;
  std::fill_n(sums, stride_, 0u);
  for (size_t row = begin; row < end;) {
    const uint8_t* block = blocks_.data() + row / kBlockRows * block_size;
    const size_t first = row % kBlockRows;
    const size_t num_rows = std::min(end - row, kBlockRows - first);
    const size_t num_blocks = std::min((end - row) / kBlockRows, kMaxBlocks);
    for (int dim = 0; dim < stride_; dim += kDistanceBlock) {
      const uint8_t* bytes = block + dim * kBlockRows;
      if (first == 0 && num_blocks > 0) {
        AddBlocks(bytes, block_size, num_blocks, sums + dim);
      } else {
        AddRows(bytes + first * kGroupDims, num_rows, sums + dim);
      }
    }
    row += first == 0 && num_blocks > 0 ? num_blocks * kBlockRows : num_rows;
  }
}

// Each minimum is the distance of another row, so at least `count` rows are within the count-th of
// them. Twice as many minima as rows that are asked for leave few more.
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
  for (size_t i = 0; i < queries_.size(); ++i) {
    int16_t* values = values_.data() + i * stride_;
    BlockQuery& query = queries_[i];
    for (size_t dim = 0; dim < stride_; ++dim) {
      values[dim] = static_cast<int16_t>(steps[i * stride_ + dim] - centers[dim]);
      query.constant += values[dim] * (values[dim] + 2 * centers[dim]);
    }
    query.values = values;
    query.num_parts = AppendParts({values, stride_});
    query.has_narrow_pairs = HasNarrowPairs({values, stride_});
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
  std::vector<int16_t> rest;  // What the parts so far do not make up; empty at first: all.
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
