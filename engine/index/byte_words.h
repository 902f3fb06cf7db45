// Words: k-means centroids of descriptors. They serve the indices that partition descriptor space
// into cells, and the word ratio filter.
#ifndef CAIRN_ENGINE_INDEX_BYTE_WORDS_H_
#define CAIRN_ENGINE_INDEX_BYTE_WORDS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/index/blocked_rows.h"
#include "engine/index/byte_descriptors.h"

namespace cairn {

// Words over a range of descriptor dimensions, rounded to bytes. Immutable; safe to use from any
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

  // Trains on a random sample of 32 descriptors per word. There are at most as many words as
  // descriptors. Deterministic by seed.
  ByteWords(const ByteDescriptors& descriptors, const Options& options);

  // Each word is the mean of a list's rows, rounded, over all `num_dims` dimensions; an empty list
  // gives zeros. `begin` holds the lists' offsets in the rows, num_lists + 1 of them. `sums` holds
  // the sums of the rows' bytes, num_lists x stride, as BlockedRows computes them.
  ByteWords(std::span<const uint32_t> sums, std::span<const uint32_t> begin, int num_dims);

  size_t size() const { return words_.size(); }

  // Converts queries to the form that SqDistances takes. `query_steps` come from ByteScale (n x
  // stride, all dimensions).
  BlockQueries Prepare(std::span<const int16_t> query_steps, int stride) const;

  // Computes the squared distances, in steps, from a query to all words, over the words'
  // dimensions. `sq_steps` must have room for size() rounded up to a multiple of kBlockRows.
  void SqDistances(const BlockQuery& query, int32_t* sq_steps) const {
    words_.Scan(query, sq_steps);
  }

  // See BlockedRows::Nearest.
  void NearestWords(const BlockQuery& query, size_t count, NearestScratch* scratch,
                    std::vector<BlockHit>* nearest) const {
    words_.Nearest(query, count, scratch, nearest);
  }

  // Returns the smallest distance. There must be at least one word.
  int32_t NearestSqDistance(const BlockQuery& query) const;

  // Returns the nearest word of each descriptor; among equally near words, the first.
  std::vector<uint32_t> NearestWords(const ByteDescriptors& descriptors) const;

  size_t MemoryBytes() const { return words_.MemoryBytes(); }

 private:
  int first_dim_;
  int num_dims_;
  BlockedRows words_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_BYTE_WORDS_H_
