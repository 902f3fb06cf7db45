// A vocabulary for each half of the descriptor: the cells of the inverted multi-index, and the
// density that the word ratio filter compares with.
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
  // Words per half as ByteWords. A single dimension is all in the first half.
  ProductWords(const ByteDescriptors& descriptors, int num_words, int num_iterations,
               uint64_t seed);

  // Pairs of words; pair (i, j) has number i * second().size() + j.
  size_t num_cells() const { return first_.size() * second_.size(); }
  std::vector<uint32_t> NearestCells(const ByteDescriptors& descriptors) const;

  const ByteWords& first() const { return first_; }
  const ByteWords& second() const { return second_; }

  // Distance in projected space from each query (n x dim) to the nearest pair of words; 0 if there
  // are none.
  std::vector<double> NearestDistances(const ByteScale& scale,
                                       const DescriptorMatrix& queries) const;

  size_t MemoryBytes() const { return first_.MemoryBytes() + second_.MemoryBytes(); }

 private:
  ByteWords first_, second_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_PRODUCT_WORDS_H_
