// The interface between the matching stage and the index of a tile's descriptors, whatever its
// kind.
#ifndef CAIRN_ENGINE_INDEX_MATCHING_INDEX_H_
#define CAIRN_ENGINE_INDEX_MATCHING_INDEX_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/features.h"
#include "engine/index/hit_collector.h"
#include "engine/index/index_options.h"
#include "storage/codebook/codebook.h"
#include "storage/tile/tile_lists.h"

namespace cairn {

// How much of an index to build at once.
enum class BuildExtent {
  kWhole,
  kFirstPart,  // The first part makes the index searchable; BuildPart builds the rest.
};

// All kinds hold the same descriptors (see ByteDescriptors) and return the same exact distances.
// They differ in recall, speed and memory. An index is immutable except for parts that are built
// later, which add hits. Safe to use from any thread. Deterministic, by seed where the options have
// one.
class MatchingIndex {
 public:
  virtual ~MatchingIndex() = default;

  // Returns true if all parts are built. A search sees the parts that were complete when it
  // started.
  virtual bool is_complete() const { return true; }
  // Builds the next missing part, if any. Threads that call this at the same time take turns, so
  // each part is built once, and the complete index does not depend on which threads built it.
  virtual void BuildPart() const {}

  // Finds the descriptors within each query's own distance: all of them (exhaustive) or most.
  // Appends to `hits`, ordered by query; a descriptor occurs at most once per query. The hits of a
  // query do not depend on the other queries. If `request.receiver` is set, hits go to the receiver
  // instead of `hits`: unordered, possibly repeated, and dependent on the receiver's return values;
  // `hits` may then be null. Returns the number of distances computed. Throws Error(kInternal) if
  // the queries do not have the codebook's dimension.
  virtual int64_t Search(const SearchRequest& request, std::vector<DescriptorHit>* hits) const = 0;

  // Maps each place in the index to a descriptor; receivers get hits by place. Empty if place i
  // holds descriptor i. Valid as long as the index.
  virtual std::span<const uint32_t> order() const { return {}; }

  // Searches with the same distance for all queries and without a receiver.
  int64_t RangeSearch(const DescriptorMatrix& queries, double max_distance,
                      std::vector<DescriptorHit>* hits) const;

  // Of the complete index.
  virtual size_t MemoryBytes() const = 0;
};

// Makes the index of n descriptors (codes: n x codebook.num_subspaces bytes, n < 2^32 - 1). The
// options must be valid. `lists` may be those of the tile. Inverted lists use them if not empty,
// which saves building them; one random grid is built in their order. Unless the index is built
// whole, codebook and codes must outlive it. Throws Error(kBadInput) if the codebook has more than
// 128 dimensions, and Error(kMapDamaged) if it lacks the same-landmark distances that random grids
// need.
std::unique_ptr<const MatchingIndex> MakeMatchingIndex(const Codebook& codebook,
                                                       std::span<const uint8_t> codes,
                                                       const IndexOptions& options,
                                                       TileLists lists = {},
                                                       BuildExtent extent = BuildExtent::kWhole);

// Returns true for inverted lists and for one random grid. These are built at once, from codes in
// the order of a tile's lists, and do not need the codes afterwards.
bool IsBuiltInListOrder(const IndexOptions& options);

// Makes such an index from codes that are in the order of the lists, as tiles store them. The
// result is that of MakeMatchingIndex with codes in tile order. Throws what MakeMatchingIndex
// throws.
std::unique_ptr<const MatchingIndex> MakeIndexInListOrder(const Codebook& codebook,
                                                          std::span<const uint8_t> codes,
                                                          const IndexOptions& options,
                                                          TileLists lists);

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_MATCHING_INDEX_H_
