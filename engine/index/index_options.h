// Options of the matching indices: the kind of a tile's index and the settings of each kind.
#ifndef CAIRN_ENGINE_INDEX_INDEX_OPTIONS_H_
#define CAIRN_ENGINE_INDEX_INDEX_OPTIONS_H_

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "storage/codebook/codebook.h"

namespace cairn {

// Random grids (paper, section "Random Grids"; Aiger, Kokiopoulou, Rivlin, ICCV 2013). The defaults
// trade recall of the nearest landmark against time and memory; they were chosen on SIFT of photos
// and on synthetic descriptors (docs/decisions/0069).
struct RandomGridsOptions {
  // N, 1 to 64. Each descriptor is in one cell of every grid. Time and memory are linear in N.
  int num_grids = 1;
  // Number of leading dimensions of the rotated descriptor (see CellHasher) that form a cell's key,
  // 1 to 128. A descriptor with fewer dimensions is hashed whole. Fewer hashed dimensions make
  // coarser cells, which give more recall per grid and more candidates.
  int num_hashed_dims = 12;
  // Side of a cell, [0.001, 1000], in units of sigma = d / sqrt(projected_dim). d is the codebook's
  // median same-landmark distance, so sigma is the standard deviation per dimension between two
  // descriptors of one landmark. In 16 dimensions, 8 sigma are 2 d.
  double cell_width_sigmas = 8.0;
  // Cells searched per grid, 1 to 128: the query's own cell, then cells across the nearest borders.
  // 40 probes find the nearest landmark 0.93 to 0.97 times as often as exhaustive search. They
  // localize as many queries as 12 in each of two smaller grids; 24 localize fewer
  // (docs/decisions/0069).
  int num_probes = 40;
  // Descriptors per cell that are compared, 1 to 10,000; of a fuller cell, a random subset. The
  // paper uses 100. Here the descriptors of a cell are contiguous in memory, so more are
  // affordable.
  int max_candidates_per_cell = 5'000;
  uint64_t seed = 1;  // Of rotations, shifts and subsets.

  // Throws Error(kInvalidArgument), naming the field.
  void Validate() const;
};

// Inverted lists: k-means cells, each with a list of descriptors that are contiguous in memory. On
// the tile on which random grids were measured, the defaults find 98 % of the nearest landmarks
// with 5,900 distances per query, and take as much memory as one random grid. 8 probes find 96 %
// and 16 probes 99 %. In the simulated cities, 12 probes answer as many queries as all 1,024; 8
// probes do not. If ingest stored lists with a tile, these are used, and num_lists, num_iterations
// and seed do not apply.
struct InvertedListsOptions {
  int num_lists = 1024;    // 1 to 65,536; a tile has at most as many lists as descriptors.
  int num_probes = 12;     // Lists searched, nearest word first; 1 to 65,536.
  int num_iterations = 5;  // Of k-means, 0 to 100.
  uint64_t seed = 1;       // Of the training sample.

  // Throws Error(kInvalidArgument), naming the field.
  void Validate() const;
};

class MatchingIndex;

// Makes an index of a kind that the engine does not know, for comparisons (lab/rivals).
class IndexFactory {
 public:
  virtual ~IndexFactory() = default;
  // The kind and all its settings. Factories with the same name must make equal indices.
  virtual std::string name() const = 0;
  // See MakeMatchingIndex.
  virtual std::unique_ptr<const MatchingIndex> Make(const Codebook& codebook,
                                                    std::span<const uint8_t> codes) const = 0;
};

enum class IndexKind { kRandomGrids, kInvertedLists, kExhaustive, kOther };

// How a tile is made searchable. The tile cache identifies tiles by payload only. Localizers with
// different IndexOptions therefore need separate caches.
struct IndexOptions {
  IndexKind kind = IndexKind::kRandomGrids;
  // Only the options of `kind` are used.
  RandomGridsOptions grids;
  InvertedListsOptions lists;
  std::shared_ptr<const IndexFactory> other = {};  // For IndexKind::kOther only.

  // Words per half of the vocabulary for DistanceFilter::kWordRatio, 0 to 4,096, for every kind of
  // index. With 0, no vocabulary is made.
  int num_reference_words = 0;

  // Throws Error(kInvalidArgument), naming the field.
  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_INDEX_OPTIONS_H_
