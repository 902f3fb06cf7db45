// Random grids: nearest-neighbour search by hashing into several randomly rotated and shifted grids
// (paper, section "Random Grids"; Aiger, Kokiopoulou, Rivlin, ICCV 2013). Against the exhaustive
// ByteDescriptors::RangeSearch it trades a few per cent of recall for a fiftieth of the time.
#ifndef CAIRN_ENGINE_MATCHING_RANDOM_GRIDS_H_
#define CAIRN_ENGINE_MATCHING_RANDOM_GRIDS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/features.h"
#include "engine/matching/bucket_table.h"
#include "engine/matching/byte_descriptors.h"
#include "engine/matching/cell_hasher.h"
#include "engine/matching/matching_options.h"
#include "storage/codebook.h"

namespace cairn {

// The index of one tile's descriptors. Cells are hashed into as many buckets a grid as there are
// descriptors, up to a factor of two; cells that collide share a bucket and its cap. Immutable;
// safe to use from any thread. Deterministic by options.seed.
class RandomGrids {
 public:
  // codes: n x codebook.num_subspaces bytes, n < 2^32 - 1. The options must be valid. Time and
  // memory are linear in n * num_grids. Throws Error(kBadInput) if the codebook has more than 128
  // dimensions, Error(kMapDamaged) if it has no same-landmark distances to set the cells' size by.
  RandomGrids(const Codebook& codebook, std::span<const uint8_t> codes,
              const RandomGridsOptions& options);

  // Finds most of the descriptors within `max_distance` of each query (n x dim, projected space);
  // those found have exact distances. Appends to `hits`, ordered by query. Returns the number of
  // distances computed. Throws Error(kInternal) if the dimension is another.
  int64_t RangeSearch(const DescriptorMatrix& queries, double max_distance,
                      std::vector<DescriptorHit>* hits) const;

  const ByteDescriptors& descriptors() const { return descriptors_; }

  size_t MemoryBytes() const;

 private:
  class Search;  // Working memory and steps of one RangeSearch.

  ByteDescriptors descriptors_;
  CellHasher hasher_;
  std::vector<BucketTable> tables_;  // One a grid.
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_MATCHING_RANDOM_GRIDS_H_
