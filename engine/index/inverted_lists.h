// Inverted lists: k-means cells. A query searches the nearest cells.
#ifndef CAIRN_ENGINE_INDEX_INVERTED_LISTS_H_
#define CAIRN_ENGINE_INDEX_INVERTED_LISTS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/index/byte_words.h"
#include "engine/index/cell_lists.h"
#include "engine/index/code_expansion.h"
#include "engine/index/matching_index.h"
#include "storage/tile/tile_lists.h"

namespace cairn {

// Groups descriptors (codes: n x codebook.num_subspaces bytes) into lists around words trained on
// them. No list is empty; without descriptors there are no lists. Ingest stores the result with a
// tile. Deterministic by seed.
TileLists MakeTileLists(const Codebook& codebook, std::span<const uint8_t> codes,
                        const InvertedListsOptions& options);

// Compares queries list by list, so that a list that several queries visit is read once.
class InvertedLists : public MatchingIndex {
 public:
  // `codes` are in list order, as OrderCodes returns them and as tiles store them.
  InvertedLists(const Codebook& codebook, std::span<const uint8_t> codes,
                const InvertedListsOptions& options, TileLists lists);

  int64_t Search(const SearchRequest& request, std::vector<DescriptorHit>* hits) const override;
  std::span<const uint32_t> order() const override { return lists_.lists().members; }
  const TileLists& lists() const { return lists_.lists(); }
  size_t MemoryBytes() const override { return words_.MemoryBytes() + lists_.MemoryBytes(); }

 private:
  struct ExpandedLists;
  InvertedLists(const ByteScale& scale, ExpandedLists&& expanded, size_t num_probes,
                TileLists&& lists);
  // Returns the visits, ordered by cell, then query.
  std::vector<CellVisit> MakeVisits(const std::vector<int16_t>& query_steps,
                                    size_t num_queries) const;

  size_t num_probes_;
  CellLists lists_;
  ByteWords words_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_INVERTED_LISTS_H_
