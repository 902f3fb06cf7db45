// Inverted multi-index (Babenko and Lempitsky, "The Inverted Multi-Index", CVPR 2012; paper,
// section of the same name).
#ifndef CAIRN_LAB_RIVALS_INVERTED_MULTI_INDEX_H_
#define CAIRN_LAB_RIVALS_INVERTED_MULTI_INDEX_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/index/cell_lists.h"
#include "engine/index/matching_index.h"
#include "engine/index/product_words.h"
#include "lab/rivals/index_methods.h"

namespace cairn {

// The cells are pairs of words, one from each half's vocabulary. A query searches the nearest
// pairs, which the multi-sequence algorithm finds. The paper encodes the residuals to the words.
// Here all kinds of index hold the same descriptors, so that they differ in the search alone.
class InvertedMultiIndex : public MatchingIndex {
 public:
  // See MakeMatchingIndex.
  InvertedMultiIndex(const Codebook& codebook, std::span<const uint8_t> codes,
                     const InvertedMultiIndexOptions& options);

  int64_t Search(const SearchRequest& request, std::vector<DescriptorHit>* hits) const override;
  std::span<const uint32_t> order() const override { return lists_.lists().members; }
  size_t MemoryBytes() const override { return words_.MemoryBytes() + lists_.MemoryBytes(); }

 private:
  class MultiSequence;  // Working memory of one search.

  InvertedMultiIndex(const ByteDescriptors& descriptors, const InvertedMultiIndexOptions& options);

  size_t num_probes_;
  ProductWords words_;
  CellLists lists_;
};

}  // namespace cairn

#endif  // CAIRN_LAB_RIVALS_INVERTED_MULTI_INDEX_H_
