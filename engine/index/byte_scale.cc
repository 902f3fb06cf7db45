#include "engine/index/byte_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/error.h"
#include "engine/index/distance_kernels.h"

namespace cairn {
namespace {

constexpr int kMaxByte = 255;
// Queries may lie outside the words' bounding box. Beyond four times its side they are clamped.
constexpr float kMinQuerySteps = -1024.0f;
constexpr float kMaxQuerySteps = 1279.0f;

// Copies num_subspaces words of `subspace_dim` bytes per code. A constant size turns the copies
// into single moves; kSubspaceDim 0 stands for any size.
template <int kSubspaceDim>
void CopyWords(std::span<const uint8_t> codes, const std::vector<uint8_t>& word_bytes,
               int num_subspaces, int subspace_dim, int stride, uint8_t* rows) {
  const size_t size = kSubspaceDim > 0 ? kSubspaceDim : subspace_dim;
  const size_t num_codes = codes.size() / num_subspaces;
  for (size_t i = 0; i < num_codes; ++i) {
    for (int m = 0; m < num_subspaces; ++m) {
      const size_t word = size_t{Codebook::kNumWords} * m + codes[i * num_subspaces + m];
      std::memcpy(rows + i * stride + m * size, word_bytes.data() + word * size, size);
    }
  }
}

// Returns the nearest step, clamped. The sum is positive, so the cast rounds down.
int16_t RoundToSteps(float value) {
  const float above = value > kMinQuerySteps ? value : kMinQuerySteps;
  const float clamped = above < kMaxQuerySteps ? above : kMaxQuerySteps;
  return static_cast<int16_t>(static_cast<int32_t>(clamped - kMinQuerySteps + 0.5f) +
                              static_cast<int32_t>(kMinQuerySteps));
}

// Computes the smallest and largest coordinate of the words in each dimension.
void WordBounds(const Codebook& codebook, std::vector<float>* min, std::vector<float>* max) {
  const int sub_dim = codebook.subspace_dim();
  min->assign(codebook.projected_dim(), std::numeric_limits<float>::max());
  max->assign(codebook.projected_dim(), std::numeric_limits<float>::lowest());
  const float* word = codebook.words.data();
  for (int m = 0; m < codebook.num_subspaces; ++m) {
    for (int w = 0; w < Codebook::kNumWords; ++w) {
      for (int j = 0; j < sub_dim; ++j, ++word) {
        const int dim = m * sub_dim + j;
        (*min)[dim] = std::min((*min)[dim], *word);
        (*max)[dim] = std::max((*max)[dim], *word);
      }
    }
  }
}

}  // namespace

ByteScale::ByteScale(const Codebook& codebook) {
  if (codebook.projected_dim() > kMaxDistanceStride) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("codebook {} projects to {} dimensions; matching takes at most {}",
                            Value(codebook.id), codebook.projected_dim(), kMaxDistanceStride));
  }
  std::vector<float> max;
  WordBounds(codebook, &offset_, &max);
  double widest = 0.0;
  for (size_t dim = 0; dim < max.size(); ++dim) {
    widest = std::max(widest, static_cast<double>(max[dim]) - offset_[dim]);
  }
  if (widest / kMaxByte >= std::numeric_limits<float>::min()) {
    step_ = static_cast<float>(widest / kMaxByte);
  }
  for (size_t dim = 0; dim < max.size(); ++dim) {
    const double middle = 0.5 * (static_cast<double>(max[dim]) + offset_[dim]);
    offset_[dim] = static_cast<float>(middle - 0.5 * kMaxByte * static_cast<double>(step_));
  }
  stride_ = (dim() + kDistanceBlock - 1) / kDistanceBlock * kDistanceBlock;
}

std::vector<uint8_t> ByteScale::WordBytes(const Codebook& codebook) const {
  const int sub_dim = codebook.subspace_dim();
  std::vector<uint8_t> word_bytes(codebook.words.size());
  for (size_t i = 0; i < word_bytes.size(); ++i) {
    const size_t subspace = i / (size_t{Codebook::kNumWords} * sub_dim);
    const double steps = (codebook.words[i] - offset_[subspace * sub_dim + i % sub_dim]) /
                         static_cast<double>(step_);
    word_bytes[i] = static_cast<uint8_t>(std::clamp(std::lround(steps), 0L, long{kMaxByte}));
  }
  return word_bytes;
}

std::vector<uint8_t> ByteScale::ExpandCodes(const Codebook& codebook,
                                            std::span<const uint8_t> codes) const {
  const int sub_dim = codebook.subspace_dim();
  const std::vector<uint8_t> word_bytes = WordBytes(codebook);
  std::vector<uint8_t> rows(codes.size() / codebook.num_subspaces * stride_);
  const auto copy = sub_dim == 1   ? CopyWords<1>
                    : sub_dim == 2 ? CopyWords<2>
                    : sub_dim == 4 ? CopyWords<4>
                                   : CopyWords<0>;
  copy(codes, word_bytes, codebook.num_subspaces, sub_dim, stride_, rows.data());
  return rows;
}

std::vector<int16_t> ByteScale::QuantizeQueries(const DescriptorMatrix& projected) const {
  const size_t num_queries = projected.rows();
  std::vector<int16_t> steps(num_queries * stride_);
  for (size_t i = 0; i < num_queries; ++i) {
    for (int dim = 0; dim < this->dim(); ++dim) {
      const float value = (projected(i, dim) - offset_[dim]) / step_;
      steps[i * stride_ + dim] = RoundToSteps(value);
    }
  }
  return steps;
}

int32_t ByteScale::MaxSqSteps(double max_distance) const {
  const double steps = max_distance / step_;
  return static_cast<int32_t>(std::min(steps * steps, double{std::numeric_limits<int32_t>::max()}));
}

void RequireQueryDim(const DescriptorMatrix& queries, int dim) {
  if (queries.cols() != dim) {
    throw Error(ErrorCode::kInternal,
                fmt::format("query descriptors have {} dimensions, the tile's codebook has {}",
                            queries.cols(), dim));
  }
}

}  // namespace cairn
