// What the matching stage asks of the index of a tile's descriptors, whatever its kind.
#ifndef CAIRN_ENGINE_INDEX_MATCHING_INDEX_H_
#define CAIRN_ENGINE_INDEX_MATCHING_INDEX_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/features.h"
#include "engine/index/index_options.h"
#include "engine/index/kernels/hit_collector.h"
#include "storage/codebook/codebook.h"
#include "storage/tile/tile_lists.h"

namespace cairn {

// How much of an index is built at once.
enum class BuildExtent {
  kWhole,
  kFirstPart,  // What a search needs to find anything; the rest is left to BuildPart.
};

// All kinds hold the same descriptors (see ByteDescriptors) and give the same, exact distances;
// they differ in what they find, how fast and in how much memory. Immutable but for parts that are
// still to be built, which add to what a search finds; safe to use from any thread. Deterministic,
// by seed where the options have one.
class MatchingIndex {
 public:
  virtual ~MatchingIndex() = default;

  // Whether all parts stand. What others build is seen by the searches that start after it.
  virtual bool is_complete() const { return true; }
  // Builds the next part, if one is missing. A thread that finds another at it waits its turn, so
  // each part is built once and the complete index is the same whoever built it.
  virtual void BuildPart() const {}

  // Finds descriptors within each query's own distance: all of them (exhaustive) or most. Appends
  // to `hits`, ordered by query; a descriptor occurs at most once for a query. The hits of a query
  // do not depend on the other queries. If `request.receiver` is set, hits go to it instead of
  // `hits`: unordered, possibly repeated, and dependent on what it returns; `hits` may then be
  // null. Returns the number of distances computed. Throws Error(kInternal) if the queries'
  // dimension is not the codebook's.
  virtual int64_t Search(const SearchRequest& request, std::vector<DescriptorHit>* hits) const = 0;

  // The descriptor at each of the index's places, by which a receiver gets its hits; empty if the
  // i-th place is that of the i-th descriptor. Valid as long as the index.
  virtual std::span<const uint32_t> order() const { return {}; }

  // Search with one distance for all queries and no bound on hits.
  int64_t RangeSearch(const DescriptorMatrix& queries, double max_distance,
                      std::vector<DescriptorHit>* hits) const;

  // Of the complete index.
  virtual size_t MemoryBytes() const = 0;
};

// Makes the index of n descriptors, codes: n x codebook.num_subspaces bytes, n < 2^32 - 1. The
// options must be valid. Inverted lists are `lists` if there are any, which saves the time to make
// them; the other kinds leave them. Throws Error(kBadInput) if the codebook has more than 128
// dimensions, Error(kMapDamaged) if it lacks the same-landmark distances that random grids need.
// Unless it is built whole, codebook and codes must outlive the index.
std::unique_ptr<const MatchingIndex> MakeMatchingIndex(const Codebook& codebook,
                                                       std::span<const uint8_t> codes,
                                                       const IndexOptions& options,
                                                       TileLists lists = {},
                                                       BuildExtent extent = BuildExtent::kWhole);

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_MATCHING_INDEX_H_
