// A vocabulary for each half of the descriptor. The pairs of words are the cells of the inverted
// multi-index, and a measure of density for the word ratio filter.
#ifndef CAIRN_ENGINE_INDEX_PRODUCT_WORDS_H_
#define CAIRN_ENGINE_INDEX_PRODUCT_WORDS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/index/byte_words.h"

namespace cairn {

// Immutable; safe to use from any thread.
class ProductWords {
 public:
  // Trains the words of each half as ByteWords does. A single dimension belongs to the first half.
  ProductWords(const ByteDescriptors& descriptors, int num_words, int num_iterations,
               uint64_t seed);

  // The number of pairs of words; pair (i, j) has number i * second().size() + j.
  size_t num_cells() const { return first_.size() * second_.size(); }
  std::vector<uint32_t> NearestCells(const ByteDescriptors& descriptors) const;

  const ByteWords& first() const { return first_; }
  const ByteWords& second() const { return second_; }

  // Returns the distance in projected space from each query (n x dim) to the nearest pair of words;
  // 0 if there are no words.
  std::vector<double> NearestDistances(const ByteScale& scale,
                                       const DescriptorMatrix& queries) const;

  size_t MemoryBytes() const { return first_.MemoryBytes() + second_.MemoryBytes(); }

 private:
  ByteWords first_, second_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_PRODUCT_WORDS_H_
