#include "engine/matching/blocked_rows.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace cairn {
namespace {

// The middle of the range of each dimension.
std::vector<int16_t> MiddleOf(const uint8_t* rows, int stride, std::span<const uint32_t> order) {
  std::vector<uint8_t> low(stride, order.empty() ? 0 : 255), high(stride, 0);
  for (const uint32_t index : order) {
    const uint8_t* row = rows + size_t{index} * stride;
    for (int dim = 0; dim < stride; ++dim) {
      low[dim] = std::min(low[dim], row[dim]);
      high[dim] = std::max(high[dim], row[dim]);
    }
  }
  std::vector<int16_t> middle(stride);
  for (int dim = 0; dim < stride; ++dim) {
    middle[dim] = static_cast<int16_t>((low[dim] + high[dim] + 1) / 2);
  }
  return middle;
}

}  // namespace

BlockedRows::BlockedRows(const uint8_t* rows, int stride, std::span<const uint32_t> order)
    : size_(order.size()), stride_(stride), centers_(MiddleOf(rows, stride, order)) {
  const size_t padded_size = (size_ + kBlockRows - 1) / kBlockRows * kBlockRows;
  blocks_.resize(padded_size * stride);
  constexpr int32_t kFarAway = 1 << 30;
  sq_norms_.resize(padded_size, kFarAway);
  for (size_t i = 0; i < size_; ++i) {
    const uint8_t* row = rows + size_t{order[i]} * stride;
    uint8_t* to =
        blocks_.data() + i / kBlockRows * kBlockRows * stride + i % kBlockRows * kGroupDims;
    int32_t sq_norm = 0;
    for (int begin = 0; begin < stride; begin += kGroupDims) {
      std::memcpy(to + begin * kBlockRows, row + begin, kGroupDims);
    }
    for (int dim = 0; dim < stride; ++dim) {
      const int32_t centered = row[dim] - centers_[dim];
      sq_norm += centered * centered;
    }
    sq_norms_[i] = sq_norm;
  }
}

void BlockedRows::Nearest(const BlockQuery& query, size_t count, std::vector<BlockHit>* hits,
                          std::vector<BlockHit>* nearest) const {
  if (count == 0) {
    return;
  }
  hits->resize(size_);
  const int32_t bound = BoundWith(BestBlockKernels(), query, count);
  const auto end =
      hits->begin() + static_cast<ptrdiff_t>(Range(query, 0, size_, bound, hits->data()));
  const auto last = hits->begin() + static_cast<ptrdiff_t>(count);
  std::nth_element(hits->begin(), last - 1, end, [](const BlockHit& a, const BlockHit& b) {
    return a.sq_distance != b.sq_distance ? a.sq_distance < b.sq_distance : a.row < b.row;
  });
  nearest->insert(nearest->end(), hits->begin(), last);
}

BlockQueries::BlockQueries(std::span<const int16_t> steps, std::span<const int16_t> centers)
    : stride_(centers.size()), values_(steps.size()), part_begin_{0} {
  const size_t num_queries = steps.size() / stride_;
  parts_.reserve(num_queries * stride_);
  part_begin_.reserve(num_queries + 1);
  constants_.reserve(num_queries);
  for (size_t query = 0; query < num_queries; ++query) {
    int16_t* values = values_.data() + query * stride_;
    int32_t constant = 0;
    for (size_t dim = 0; dim < stride_; ++dim) {
      values[dim] = static_cast<int16_t>(steps[query * stride_ + dim] - centers[dim]);
      constant += values[dim] * (values[dim] + 2 * centers[dim]);
    }
    constants_.push_back(constant);
    part_begin_.push_back(part_begin_.back() + AppendParts({values, stride_}));
  }
}

uint32_t BlockQueries::AppendParts(std::span<const int16_t> values) {
  constexpr int16_t kMinPart = std::numeric_limits<int8_t>::min();
  constexpr int16_t kMaxPart = std::numeric_limits<int8_t>::max();
  std::vector<int16_t> rest;  // What the parts so far do not make up; empty at first: all.
  for (uint32_t num_parts = 1;; ++num_parts) {
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
