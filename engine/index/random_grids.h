// Random grids: nearest-neighbour search by hashing into several randomly rotated and shifted grids
// (paper, section "Random Grids"; Aiger, Kokiopoulou, Rivlin, ICCV 2013). Against the exhaustive
// ExhaustiveIndex it trades a few per cent of recall for a ninetieth of the time.
#ifndef CAIRN_ENGINE_INDEX_RANDOM_GRIDS_H_
#define CAIRN_ENGINE_INDEX_RANDOM_GRIDS_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "core/features.h"
#include "engine/index/cell_hasher.h"
#include "engine/index/cell_lists.h"
#include "engine/index/hash_buckets.h"
#include "engine/index/kernels/code_expansion.h"
#include "engine/index/matching_index.h"
#include "storage/codebook/codebook.h"

namespace cairn {

// Every grid holds the descriptors themselves, those of a cell in a row in memory, and a search
// goes through the cells that queries visit in the order of memory, as in inverted lists: to
// compare the descriptor beside the last one takes a tenth of the time, or less, of reading one
// from anywhere. Cells are hashed into buckets, four to eight times as few as there are
// descriptors; those that collide are searched together. Its parts are the grids: a search looks
// into those that stand when it begins. Memory: 24 bytes a descriptor and grid, a byte a dimension
// (padded, see distance_kernels.h), norm and number, and half a byte to a byte of bucket.
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
  // That of the first grid.
  std::span<const uint32_t> order() const override { return grids_.front()->lists().members; }
  size_t MemoryBytes() const override;

 private:
  int num_standing() const { return num_standing_.load(std::memory_order_acquire); }
  CellLists MakeGrid(int grid) const;
  // The visits of all queries to the buckets of a grid, in the order of memory.
  std::vector<CellVisit> MakeVisits(const DescriptorMatrix& queries, int grid) const;

  // What grids are built of; not used once all of them stand.
  const Codebook* codebook_;
  std::span<const uint8_t> codes_;
  CodeWords words_;

  RandomGridsOptions options_;
  CellHasher hasher_;
  int num_bucket_bits_;
  mutable std::mutex mutex_;  // Held while a grid is built.
  // In order(), of the descriptors. Empty once all grids stand.
  mutable std::vector<uint32_t> places_;
  // Of which the first num_standing_ may be read by anyone.
  mutable std::vector<std::optional<CellLists>> grids_;
  mutable std::atomic<int> num_standing_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_RANDOM_GRIDS_H_
