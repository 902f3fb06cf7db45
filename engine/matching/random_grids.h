// Random grids: nearest-neighbour search by hashing into several randomly rotated and shifted grids
// (paper, section "Random Grids"; Aiger, Kokiopoulou, Rivlin, ICCV 2013). Against the exhaustive
// ExhaustiveIndex it trades a few per cent of recall for a fortieth of the time.
#ifndef CAIRN_ENGINE_MATCHING_RANDOM_GRIDS_H_
#define CAIRN_ENGINE_MATCHING_RANDOM_GRIDS_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "core/features.h"
#include "engine/matching/bucket_table.h"
#include "engine/matching/byte_descriptors.h"
#include "engine/matching/cell_hasher.h"
#include "engine/matching/matching_index.h"
#include "storage/codebook.h"

namespace cairn {

// Cells are hashed into as many buckets a grid as there are descriptors, up to a factor of two;
// cells that collide share a bucket and its cap. Of a cell's descriptors those are compared with
// the query that their sketches (cell_sketch.h) do not tell to be farther away than asked for; a
// few per cent of the farthest hits are lost by that. Its parts are the grids: a search looks into
// those that stand when it begins. Memory: the descriptors themselves, a byte a dimension (padded,
// see distance_kernels.h), and 10 to 12 bytes a descriptor and grid: its index, its sketch, and
// half to one bucket. That is 16 and 51 bytes a descriptor for the defaults and a tile of 500,000.
// Safe to use from any thread. Deterministic by options.seed.
class RandomGrids : public MatchingIndex {
 public:
  // See MakeMatchingIndex. Time and memory are linear in n * num_grids. Throws Error(kMapDamaged)
  // if the codebook has no same-landmark distances to set the cells' size by.
  RandomGrids(const Codebook& codebook, std::span<const uint8_t> codes,
              const RandomGridsOptions& options, BuildExtent extent = BuildExtent::kWhole);

  bool is_complete() const override { return num_standing() == hasher_.num_grids(); }
  void BuildPart() const override;

  int64_t Search(const SearchRequest& request, std::vector<DescriptorHit>* hits) const override;
  size_t MemoryBytes() const override;

 private:
  class Searcher;  // Working memory and steps of one Search.

  int num_standing() const { return num_standing_.load(std::memory_order_acquire); }

  // What grids are built of; not used once all of them stand.
  const Codebook* codebook_;
  std::span<const uint8_t> codes_;
  RandomGridsOptions options_;

  ByteDescriptors descriptors_;
  CellHasher hasher_;
  mutable std::mutex mutex_;              // Held while a grid is built.
  mutable BucketTable::Scratch scratch_;  // Empty once all grids stand.
  // One a grid, of which the first num_standing_ may be read by anyone.
  mutable std::vector<std::optional<BucketTable>> tables_;
  mutable std::atomic<int> num_standing_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_MATCHING_RANDOM_GRIDS_H_
