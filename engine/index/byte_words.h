// Vocabularies: k-means centroids of descriptors, for the indices that cut the space into cells and
// for the word ratio filter.
#ifndef CAIRN_ENGINE_INDEX_BYTE_WORDS_H_
#define CAIRN_ENGINE_INDEX_BYTE_WORDS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/index/kernels/blocked_rows.h"
#include "engine/index/kernels/byte_descriptors.h"

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

  // The mean of each list's rows, over all of `num_dims` dimensions, rounded; zeros for an empty
  // list. `begin` are the offsets of the lists in the rows, one more than there are; `sums` are
  // those of the rows' bytes, num_lists x stride, as BlockedRows adds them up.
  ByteWords(std::span<const uint32_t> sums, std::span<const uint32_t> begin, int num_dims);

  size_t size() const { return words_.size(); }

  // Queries in the form that SqDistances takes; steps as ByteScale makes them (n x stride, all
  // dimensions).
  BlockQueries Prepare(std::span<const int16_t> query_steps, int stride) const;

  // Squared distances in steps of a query to all words, over the words' dimensions; there must be
  // room for size() rounded up to a multiple of kBlockRows.
  void SqDistances(const BlockQuery& query, int32_t* sq_steps) const {
    words_.Scan(query, sq_steps);
  }

  // See BlockedRows::Nearest.
  void NearestWords(const BlockQuery& query, size_t count, NearestScratch* scratch,
                    std::vector<BlockHit>* nearest) const {
    words_.Nearest(query, count, scratch, nearest);
  }

  // The smallest distance; there must be words.
  int32_t NearestSqDistance(const BlockQuery& query) const;

  // The nearest word of each descriptor, of equally near ones the first.
  std::vector<uint32_t> NearestWords(const ByteDescriptors& descriptors) const;

  size_t MemoryBytes() const { return words_.MemoryBytes(); }

 private:
  int first_dim_;
  int num_dims_;
  BlockedRows words_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_BYTE_WORDS_H_
