// Random grids: nearest-neighbor search by hashing into several randomly rotated and shifted grids
// (paper, section "Random Grids"; Aiger, Kokiopoulou, Rivlin, ICCV 2013). Compared with
// ExhaustiveIndex, random grids lose a few per cent of recall and take a ninetieth of the time.
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
#include "engine/index/code_expansion.h"
#include "engine/index/hash_buckets.h"
#include "engine/index/matching_index.h"
#include "storage/codebook/codebook.h"

namespace cairn {

// Every grid holds a copy of the descriptors, and the descriptors of a cell are contiguous in
// memory. A search visits the cells of all queries in memory order, as inverted lists do: comparing
// the next descriptor in memory takes at most a tenth of the time of reading one from elsewhere.
// Cells are hashed into buckets; there are four to eight times as many descriptors as buckets.
// Cells that collide are searched together.
//
// The parts of the index are the grids. A search uses the grids that are built when it begins.
//
// Memory: 24 bytes per descriptor and grid (a byte per dimension, padded as in distance_kernels.h,
// the norm and the number), plus half a byte to a byte for the buckets. Safe to use from any
// thread. Deterministic by options.seed.
class RandomGrids : public MatchingIndex {
 public:
  // See MakeMatchingIndex. Time and memory are linear in n * num_grids. Throws Error(kMapDamaged)
  // if the codebook lacks the same-landmark distances from which the size of cells follows.
  // descriptors[i] is the descriptor of row i of `codes`; if empty, row i is descriptor i. Building
  // takes less time if similar rows are close together, because they fall into the same cells.
  RandomGrids(const Codebook& codebook, std::span<const uint8_t> codes,
              const RandomGridsOptions& options, BuildExtent extent = BuildExtent::kWhole,
              std::span<const uint32_t> descriptors = {});

  bool is_complete() const override { return num_built() == hasher_.num_grids(); }
  void BuildPart() const override;

  int64_t Search(const SearchRequest& request, std::vector<DescriptorHit>* hits) const override;
  // The order of the first grid.
  std::span<const uint32_t> order() const override { return grids_.front()->lists().members; }
  size_t MemoryBytes() const override;

 private:
  int num_built() const { return num_built_.load(std::memory_order_acquire); }
  // Builds the next grid. The first grid takes the constructor's `descriptors`.
  void AddGrid(std::span<const uint32_t> descriptors) const;
  CellLists MakeGrid(int grid, std::span<const uint32_t> descriptors) const;
  // Returns the visits of all queries to the buckets of a grid, in memory order.
  std::vector<CellVisit> MakeVisits(const DescriptorMatrix& queries, int grid) const;

  // Input for building grids; not used once all grids are built.
  const Codebook* codebook_;
  std::span<const uint8_t> codes_;
  CodeWords words_;

  RandomGridsOptions options_;
  CellHasher hasher_;
  int num_bucket_bits_;
  mutable std::mutex mutex_;  // Held while a grid is built.
  // The place in order() of each row of codes. Empty once all grids are built.
  mutable std::vector<uint32_t> places_;
  // Any thread may read the first num_built_ grids.
  mutable std::vector<std::optional<CellLists>> grids_;
  mutable std::atomic<int> num_built_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_RANDOM_GRIDS_H_
