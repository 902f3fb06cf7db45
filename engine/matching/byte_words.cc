#include "engine/matching/byte_words.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "engine/matching/distance_kernels.h"
#include "engine/matching/random_bits.h"

namespace cairn {
namespace {

constexpr size_t kSamplesPerWord = 32;

// The first `count` of a random permutation of [0, size).
std::vector<uint32_t> RandomSample(size_t size, size_t count, uint64_t seed) {
  std::vector<uint32_t> indices(size);
  std::iota(indices.begin(), indices.end(), 0u);
  for (size_t i = 0; i < count; ++i) {
    std::swap(indices[i], indices[i + RandomBits(seed, i) % (size - i)]);
  }
  indices.resize(count);
  return indices;
}

}  // namespace

ByteWords::ByteWords(const ByteDescriptors& descriptors, const Options& options)
    : first_dim_(options.first_dim),
      num_dims_(options.num_dims),
      stride_((num_dims_ + kDistanceBlock - 1) / kDistanceBlock * kDistanceBlock),
      size_(std::min<size_t>(options.num_words, descriptors.size())),
      rows_(size_ * stride_) {
  const std::vector<uint32_t> sample = RandomSample(
      descriptors.size(), std::min(kSamplesPerWord * size_, descriptors.size()), options.seed);
  for (size_t word = 0; word < size_; ++word) {
    const uint8_t* row =
        descriptors.rows() + size_t{sample[word]} * descriptors.scale().stride() + first_dim_;
    std::copy(row, row + num_dims_, rows_.begin() + static_cast<ptrdiff_t>(word * stride_));
  }
  for (int i = 0; i < options.num_iterations; ++i) {
    Iterate(descriptors, sample);
  }
}

// Lloyd's iteration. A word that no sample is nearest to stays where it is.
void ByteWords::Iterate(const ByteDescriptors& descriptors, std::span<const uint32_t> sample) {
  std::vector<int32_t> sums(size_ * num_dims_, 0), counts(size_, 0), sq_steps(size_);
  std::vector<int16_t> query(stride_);
  for (const uint32_t descriptor : sample) {
    const uint8_t* row =
        descriptors.rows() + size_t{descriptor} * descriptors.scale().stride() + first_dim_;
    const uint32_t word = NearestWord(row, query, sq_steps);
    ++counts[word];
    for (int dim = 0; dim < num_dims_; ++dim) {
      sums[word * num_dims_ + dim] += row[dim];
    }
  }
  for (size_t word = 0; word < size_; ++word) {
    for (int dim = 0; dim < num_dims_ && counts[word] > 0; ++dim) {
      rows_[word * stride_ + dim] =
          static_cast<uint8_t>((sums[word * num_dims_ + dim] + counts[word] / 2) / counts[word]);
    }
  }
}

uint32_t ByteWords::NearestWord(const uint8_t* row, std::span<int16_t> query,
                                std::span<int32_t> sq_steps) const {
  std::copy(row, row + num_dims_, query.begin());
  BestDistanceKernels().scan(query.data(), rows_.data(), stride_, size_, sq_steps.data());
  return static_cast<uint32_t>(std::min_element(sq_steps.begin(), sq_steps.end()) -
                               sq_steps.begin());
}

void ByteWords::SqDistances(const int16_t* query_steps, std::span<int32_t> sq_steps) const {
  std::array<int16_t, kMaxDistanceStride> query{};
  std::copy(query_steps + first_dim_, query_steps + first_dim_ + num_dims_, query.begin());
  BestDistanceKernels().scan(query.data(), rows_.data(), stride_, size_, sq_steps.data());
}

std::vector<uint32_t> ByteWords::NearestWords(const ByteDescriptors& descriptors) const {
  std::vector<int16_t> query(stride_);
  std::vector<int32_t> sq_steps(size_);
  std::vector<uint32_t> words(descriptors.size());
  const uint8_t* row = descriptors.rows() + first_dim_;
  for (uint32_t& word : words) {
    word = NearestWord(row, query, sq_steps);
    row += descriptors.scale().stride();
  }
  return words;
}

}  // namespace cairn
