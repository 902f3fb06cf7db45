// Vocabularies: k-means centroids of descriptors, for the indices that cut the space into cells and
// for the word ratio filter.
#ifndef CAIRN_ENGINE_MATCHING_BYTE_WORDS_H_
#define CAIRN_ENGINE_MATCHING_BYTE_WORDS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/matching/byte_descriptors.h"

namespace cairn {

// Words over some dimensions of descriptors, each rounded to bytes. Immutable; safe to use from any
// thread.
class ByteWords {
 public:
  struct Options {
    int first_dim = 0;
    int num_dims = 0;
    int num_words = 0;
    int num_iterations = 0;
    uint64_t seed = 1;
  };

  // Trains on a random sample of 32 descriptors a word. There are at most as many words as
  // descriptors. Deterministic by seed.
  ByteWords(const ByteDescriptors& descriptors, const Options& options);

  size_t size() const { return size_; }

  // Squared distance in steps of a query (as ByteScale makes them, all dimensions) to each of the
  // size() words, over the words' dimensions.
  void SqDistances(const int16_t* query_steps, std::span<int32_t> sq_steps) const;

  // The nearest word of each descriptor, of equally near ones the first.
  std::vector<uint32_t> NearestWords(const ByteDescriptors& descriptors) const;

  size_t MemoryBytes() const { return rows_.capacity(); }

 private:
  // The nearest word of a descriptor's row. Both spans are working memory: stride_ and size_.
  uint32_t NearestWord(const uint8_t* row, std::span<int16_t> query,
                       std::span<int32_t> sq_steps) const;
  void Iterate(const ByteDescriptors& descriptors, std::span<const uint32_t> sample);

  int first_dim_;
  int num_dims_;
  int stride_;
  size_t size_ = 0;
  std::vector<uint8_t> rows_;  // size_ x stride_; the padding is 0.
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_MATCHING_BYTE_WORDS_H_
