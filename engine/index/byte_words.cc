#include "engine/index/byte_words.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <utility>

#include "core/random.h"
#include "engine/index/distance_kernels.h"

namespace cairn {
namespace {

constexpr size_t kSamplesPerWord = 32;
// Number of descriptors that are prepared as queries together.
constexpr size_t kDescriptorsPerBatch = 256;

// Rounds up to whole blocks. Zero dimensions take one block, too.
int PaddedDims(int num_dims) {
  return std::max(1, (num_dims + kDistanceBlock - 1) / kDistanceBlock) * kDistanceBlock;
}

// Returns the first `count` numbers of a random permutation of [0, size).
std::vector<uint32_t> RandomSample(size_t size, size_t count, uint64_t seed) {
  std::vector<uint32_t> indices(size);
  std::iota(indices.begin(), indices.end(), 0u);
  for (size_t i = 0; i < count; ++i) {
    std::swap(indices[i], indices[i + RandomBits(seed, i) % (size - i)]);
  }
  indices.resize(count);
  return indices;
}

// Copies some dimensions of the rows and pads them: count x PaddedDims(num_dims).
template <typename To, typename From>
std::vector<To> CutDims(const From* rows, size_t count, int stride, int first_dim, int num_dims) {
  std::vector<To> cut(count * PaddedDims(num_dims), 0);
  for (size_t i = 0; i < count; ++i) {
    const From* row = rows + i * stride + first_dim;
    std::copy(row, row + num_dims, cut.begin() + static_cast<ptrdiff_t>(i * PaddedDims(num_dims)));
  }
  return cut;
}

BlockedRows MakeBlocks(const std::vector<uint8_t>& rows, int stride) {
  std::vector<uint32_t> order(rows.size() / stride);
  std::iota(order.begin(), order.end(), 0u);
  return BlockedRows(rows.data(), stride, order);
}

// Returns the nearest of `words` for each of `count` rows with as many dimensions as the words.
std::vector<uint32_t> Nearest(const BlockedRows& words, const uint8_t* rows, size_t count,
                              int stride, int first_dim, int num_dims) {
  std::vector<uint32_t> nearest;
  nearest.reserve(count);
  for (size_t begin = 0; begin < count; begin += kDescriptorsPerBatch) {
    const size_t size = std::min(kDescriptorsPerBatch, count - begin);
    const BlockQueries queries(
        CutDims<int16_t>(rows + begin * stride, size, stride, first_dim, num_dims),
        words.centers());
    for (size_t i = 0; i < size; ++i) {
      nearest.push_back(static_cast<uint32_t>(words.Nearest(queries[i])));
    }
  }
  return nearest;
}

// Runs one Lloyd iteration on `samples` (n x PaddedDims(num_dims)). A word that is nearest to no
// sample does not move.
void Iterate(const std::vector<uint8_t>& samples, int num_dims, std::vector<uint8_t>* words) {
  const int stride = PaddedDims(num_dims);
  const size_t num_words = words->size() / stride;
  const std::vector<uint32_t> nearest = Nearest(MakeBlocks(*words, stride), samples.data(),
                                                samples.size() / stride, stride, 0, num_dims);
  std::vector<int32_t> sums(words->size(), 0), counts(num_words, 0);
  for (size_t i = 0; i < nearest.size(); ++i) {
    ++counts[nearest[i]];
    for (int dim = 0; dim < num_dims; ++dim) {
      sums[nearest[i] * stride + dim] += samples[i * stride + dim];
    }
  }
  for (size_t word = 0; word < num_words; ++word) {
    for (int dim = 0; dim < num_dims && counts[word] > 0; ++dim) {
      (*words)[word * stride + dim] =
          static_cast<uint8_t>((sums[word * stride + dim] + counts[word] / 2) / counts[word]);
    }
  }
}

BlockedRows Train(const ByteDescriptors& descriptors, const ByteWords::Options& options) {
  const int descriptor_stride = descriptors.scale().stride();
  const size_t num_words = std::min<size_t>(options.num_words, descriptors.size());
  const std::vector<uint32_t> sample = RandomSample(
      descriptors.size(), std::min(kSamplesPerWord * num_words, descriptors.size()), options.seed);
  const int stride = PaddedDims(options.num_dims);
  std::vector<uint8_t> samples(sample.size() * stride, 0);
  for (size_t i = 0; i < sample.size(); ++i) {
    const uint8_t* row =
        descriptors.rows() + size_t{sample[i]} * descriptor_stride + options.first_dim;
    std::copy(row, row + options.num_dims, samples.begin() + static_cast<ptrdiff_t>(i * stride));
  }
  std::vector<uint8_t> words(samples.begin(),
                             samples.begin() + static_cast<ptrdiff_t>(num_words * stride));
  for (int i = 0; i < options.num_iterations && num_words > 0; ++i) {
    Iterate(samples, options.num_dims, &words);
  }
  return MakeBlocks(words, stride);
}

BlockedRows MeansOfLists(std::span<const uint32_t> sums, std::span<const uint32_t> begin,
                         int stride) {
  std::vector<uint8_t> means(sums.size(), 0);
  for (size_t i = 0; i < sums.size(); ++i) {
    const size_t list = i / stride;
    const uint32_t count = begin[list + 1] - begin[list];
    means[i] = count == 0 ? 0 : static_cast<uint8_t>((sums[i] + count / 2) / count);
  }
  return MakeBlocks(means, stride);
}

}  // namespace

ByteWords::ByteWords(std::span<const uint32_t> sums, std::span<const uint32_t> begin, int num_dims)
    : first_dim_(0), num_dims_(num_dims), words_(MeansOfLists(sums, begin, PaddedDims(num_dims))) {}

ByteWords::ByteWords(const ByteDescriptors& descriptors, const Options& options)
    : first_dim_(options.first_dim),
      num_dims_(options.num_dims),
      words_(Train(descriptors, options)) {}

BlockQueries ByteWords::Prepare(std::span<const int16_t> query_steps, int stride) const {
  return BlockQueries(CutDims<int16_t>(query_steps.data(), query_steps.size() / stride, stride,
                                       first_dim_, num_dims_),
                      words_.centers());
}

int32_t ByteWords::NearestSqDistance(const BlockQuery& query) const {
  std::array<BlockHit, 1 + kRangeSlack> hits;
  const size_t word = words_.Nearest(query);
  words_.Range(query, word, word + 1, std::numeric_limits<int32_t>::max(), hits.data());
  return hits.front().sq_distance;
}

std::vector<uint32_t> ByteWords::NearestWords(const ByteDescriptors& descriptors) const {
  return Nearest(words_, descriptors.rows(), descriptors.size(), descriptors.scale().stride(),
                 first_dim_, num_dims_);
}

}  // namespace cairn
