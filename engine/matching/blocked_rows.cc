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

BlockQueries::BlockQueries(std::span<const int16_t> steps, std::span<const int16_t> centers)
    : stride_(centers.size()), values_(steps.begin(), steps.end()), part_begin_{0} {
  constexpr int kMinPart = std::numeric_limits<int8_t>::min();
  constexpr int kMaxPart = std::numeric_limits<int8_t>::max();
  const size_t num_queries = steps.size() / stride_;
  parts_.reserve(num_queries * stride_);
  std::vector<int> rest(stride_);
  for (size_t query = 0; query < num_queries; ++query) {
    int32_t constant = 0;
    for (size_t dim = 0; dim < stride_; ++dim) {
      int16_t& value = values_[query * stride_ + dim];
      value = static_cast<int16_t>(value - centers[dim]);
      constant += value * value + 2 * value * centers[dim];
      rest[dim] = value;
    }
    constants_.push_back(constant);
    uint32_t num_parts = 0;
    do {
      for (int& value : rest) {
        const int part = std::clamp(value, kMinPart, kMaxPart);
        parts_.push_back(static_cast<int8_t>(part));
        value -= part;
      }
      ++num_parts;
    } while (std::any_of(rest.begin(), rest.end(), [](int value) { return value != 0; }));
    part_begin_.push_back(part_begin_.back() + num_parts);
  }
}

}  // namespace cairn
