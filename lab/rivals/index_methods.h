// All methods to search a tile: the engine's own and the rivals.
#ifndef CAIRN_LAB_RIVALS_INDEX_METHODS_H_
#define CAIRN_LAB_RIVALS_INDEX_METHODS_H_

#include <cstdint>

#include "engine/index/index_options.h"

namespace cairn {

// Inverted multi-index (Babenko and Lempitsky, CVPR 2012; paper, section "The inverted
// multi-index"). The cells are pairs of words from two vocabularies, one for each half of the
// descriptor.
struct InvertedMultiIndexOptions {
  int num_words = 1000;  // Per vocabulary, 1 to 4,096 (paper: 1,000).
  // Number of word pairs to search, nearest first and including empty ones; 1 to 1,000,000 (paper:
  // 300 to 1,000).
  int num_probes = 300;
  int num_iterations = 5;  // K-means iterations, 0 to 100.
  uint64_t seed = 1;       // Seed of the training sample.

  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;
};

// A kd-tree searched best bin first (Beis and Lowe, CVPR 1997).
struct KdTreeOptions {
  int max_leaf_size = 32;  // Descriptors per leaf, contiguous in memory; 1 to 100,000.
  int num_probes = 64;     // Leaves to search, nearest first; 1 to 1,000,000.

  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;
};

enum class IndexMethod { kRandomGrids, kInvertedLists, kInvertedMultiIndex, kKdTree, kExhaustive };
const char* IndexMethodName(IndexMethod method);  // "random_grids", "inverted_multi_index", ...

// Only the options of the chosen method are used.
struct IndexMethodOptions {
  RandomGridsOptions grids = {};
  InvertedListsOptions lists = {};
  InvertedMultiIndexOptions multi_index = {};
  KdTreeOptions kd_tree = {};
};

// Returns options with which the engine searches its tiles by this method. Throws
// Error(kInvalidArgument) if an option is out of range.
IndexOptions MakeIndexOptions(IndexMethod method, const IndexMethodOptions& options = {});

}  // namespace cairn

#endif  // CAIRN_LAB_RIVALS_INDEX_METHODS_H_
