#include "engine/index/matching_index.h"

#include <utility>

#include "core/check.h"
#include "engine/index/exhaustive_index.h"
#include "engine/index/inverted_lists.h"
#include "engine/index/random_grids.h"

namespace cairn {

int64_t MatchingIndex::RangeSearch(const DescriptorMatrix& queries, double max_distance,
                                   std::vector<DescriptorHit>* hits) const {
  const std::vector<double> max_distances(queries.rows(), max_distance);
  return Search({queries, max_distances}, hits);
}

std::unique_ptr<const MatchingIndex> MakeMatchingIndex(const Codebook& codebook,
                                                       std::span<const uint8_t> codes,
                                                       const IndexOptions& options, TileLists lists,
                                                       BuildExtent extent) {
  switch (options.kind) {
    case IndexKind::kRandomGrids:
      return std::make_unique<RandomGrids>(codebook, codes, options.grids, extent);
    case IndexKind::kInvertedLists: {
      if (lists.empty()) {
        lists = MakeTileLists(codebook, codes, options.lists);
      }
      const LargeVector<uint8_t> ordered = OrderCodes(codes, codebook.num_subspaces, lists);
      return std::make_unique<InvertedLists>(codebook, ordered, options.lists, std::move(lists));
    }
    case IndexKind::kExhaustive:
      return std::make_unique<ExhaustiveIndex>(codebook, codes);
    case IndexKind::kOther:
      return options.other->Make(codebook, codes);
  }
  CAIRN_CHECK(false, "unknown IndexKind");
  return nullptr;
}

}  // namespace cairn
