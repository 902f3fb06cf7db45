// Options of the matching indices: which kind a tile is searched with, and its knobs.
#ifndef CAIRN_ENGINE_INDEX_INDEX_OPTIONS_H_
#define CAIRN_ENGINE_INDEX_INDEX_OPTIONS_H_

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "storage/codebook/codebook.h"

namespace cairn {

// Random grids (paper, section "Random Grids"; Aiger, Kokiopoulou, Rivlin, ICCV 2013). The defaults
// were chosen on SIFT of photos and on synthetic descriptors, for recall of the nearest landmark
// against time and memory (docs/decisions/0010).
struct RandomGridsOptions {
  // N, 1 to 64: each descriptor stands in one cell of every grid. Time and memory are linear in it.
  int num_grids = 2;
  // Leading dimensions of the rotated descriptor (see CellHasher) that make up a cell's key, 1 to
  // 128; a smaller descriptor is hashed whole. Fewer make coarser cells: more recall a grid, more
  // candidates.
  int num_hashed_dims = 10;
  // Side of a cell, [0.001, 1000], in units of sigma = d / sqrt(projected_dim), where d is the
  // codebook's median same-landmark distance: the standard deviation, per dimension, between two
  // descriptors of one landmark. 6 in 16 dimensions is 1.5 times d.
  double cell_width_sigmas = 6.0;
  // Cells looked into per grid, 1 to 128: the own one, then those across the nearest borders. 12
  // find the nearest landmark 0.92 to 0.96 times as often as exhaustive search, 20 0.95 to 0.98
  // times, 28 0.97 to 0.99 times; no more queries were localized with 20, 28 or 56 than with 12,
  // fewer with 8 (docs/decisions/0010).
  int num_probes = 12;
  // Descriptors of a cell that are compared, 1 to 10,000; of a fuller cell a random subset. The
  // paper has 100; here the descriptors of a cell lie in a row, and more is affordable.
  int max_candidates_per_cell = 5'000;
  uint64_t seed = 1;  // Of rotations, shifts and subsets.

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

// Inverted lists: k-means cells, each a list of descriptors that lie in a row in memory. On the
// same tile the defaults find 98 % with 5,900 descriptors a query, in about the time that random
// grids take and in 24 bytes a descriptor instead of 49. 8 probes find 96 %, 16 find 99 %; in
// the simulated cities 12 answer as many queries as all 1,024, and 8 do not. Lists that ingest has
// stored with a tile are taken as they are, whatever num_lists, num_iterations and seed.
struct InvertedListsOptions {
  int num_lists = 1024;    // 1 to 65,536; a tile with fewer descriptors has fewer.
  int num_probes = 12;     // Lists looked into, nearest word first; 1 to 65,536.
  int num_iterations = 5;  // Of k-means, 0 to 100.
  uint64_t seed = 1;       // Of the training sample.

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

class MatchingIndex;

// Makes an index of a kind that the engine does not know: what a comparison brings along
// (lab/rivals/index).
class IndexFactory {
 public:
  virtual ~IndexFactory() = default;
  // The kind and all its settings: factories of one name make equal indices.
  virtual std::string name() const = 0;
  // As MakeMatchingIndex, which see.
  virtual std::unique_ptr<const MatchingIndex> Make(const Codebook& codebook,
                                                    std::span<const uint8_t> codes) const = 0;
};

enum class IndexKind { kRandomGrids, kInvertedLists, kExhaustive, kOther };
const char* IndexKindName(IndexKind kind);  // "random_grids", "inverted_lists", ...

// What a tile is made searchable with. The tile cache knows tiles by their payload only, so a cache
// must be used with one IndexOptions: localizers that differ in it need a cache each.
struct IndexOptions {
  IndexKind kind = IndexKind::kRandomGrids;
  // Only those of `kind` are used.
  RandomGridsOptions grids;
  InvertedListsOptions lists;
  std::shared_ptr<const IndexFactory> other = {};  // Of IndexKind::kOther only.

  // Words per half of the vocabulary that DistanceFilter::kWordRatio compares with, 0 to 4,096; 0:
  // none is made. Whatever the kind.
  int num_reference_words = 0;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_INDEX_OPTIONS_H_
