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

bool IsBuiltInListOrder(const IndexOptions& options) {
  return options.kind == IndexKind::kInvertedLists ||
         (options.kind == IndexKind::kRandomGrids && options.grids.num_grids == 1);
}

std::unique_ptr<const MatchingIndex> MakeIndexInListOrder(const Codebook& codebook,
                                                          std::span<const uint8_t> codes,
                                                          const IndexOptions& options,
                                                          TileLists lists) {
  CAIRN_CHECK(IsBuiltInListOrder(options), "the index is built in list order");
  if (options.kind == IndexKind::kInvertedLists) {
    return std::make_unique<InvertedLists>(codebook, codes, options.lists, std::move(lists));
  }
  return std::make_unique<RandomGrids>(codebook, codes, options.grids, BuildExtent::kWhole,
                                       lists.members);
}

std::unique_ptr<const MatchingIndex> MakeMatchingIndex(const Codebook& codebook,
                                                       std::span<const uint8_t> codes,
                                                       const IndexOptions& options, TileLists lists,
                                                       BuildExtent extent) {
  if (options.kind == IndexKind::kInvertedLists && lists.empty()) {
    lists = MakeTileLists(codebook, codes, options.lists);
  }
  if (IsBuiltInListOrder(options)) {
    const LargeVector<uint8_t> ordered = OrderCodes(codes, codebook.num_subspaces, lists);
    return MakeIndexInListOrder(codebook, ordered, options, std::move(lists));
  }
  switch (options.kind) {
    case IndexKind::kRandomGrids:
      return std::make_unique<RandomGrids>(codebook, codes, options.grids, extent);
    case IndexKind::kExhaustive:
      return std::make_unique<ExhaustiveIndex>(codebook, codes);
    case IndexKind::kOther:
      return options.other->Make(codebook, codes);
    case IndexKind::kInvertedLists:
      break;
  }
  CAIRN_CHECK(false, "unknown IndexKind");
  return nullptr;
}

}  // namespace cairn
