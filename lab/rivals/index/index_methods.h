// Every way to search a tile, the engine's own and those it is compared with.
#ifndef CAIRN_LAB_RIVALS_INDEX_INDEX_METHODS_H_
#define CAIRN_LAB_RIVALS_INDEX_INDEX_METHODS_H_

#include <cstdint>

#include "engine/index/index_options.h"

namespace cairn {

// Inverted multi-index (Babenko and Lempitsky, CVPR 2012; paper, section "The inverted
// multi-index"): the cells are pairs of words of two vocabularies, one for each half of the
// descriptor.
struct InvertedMultiIndexOptions {
  int num_words = 1000;  // Of each vocabulary, 1 to 4,096 (paper: 1,000).
  // Pairs of words looked into, nearest first, empty ones included; 1 to 1,000,000 (paper: 300 to
  // 1,000).
  int num_probes = 300;
  int num_iterations = 5;  // Of k-means, 0 to 100.
  uint64_t seed = 1;       // Of the training sample.

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

// A kd-tree searched best bin first (Beis and Lowe, CVPR 1997).
struct KdTreeOptions {
  int max_leaf_size = 32;  // 1 to 100,000: descriptors of a leaf, which lie in a row in memory.
  int num_probes = 64;     // Leaves looked into, nearest first; 1 to 1,000,000.

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

enum class IndexMethod { kRandomGrids, kInvertedLists, kInvertedMultiIndex, kKdTree, kExhaustive };
const char* IndexMethodName(IndexMethod method);  // "random_grids", "inverted_multi_index", ...

// Only those of the method are used.
struct IndexMethodOptions {
  RandomGridsOptions grids = {};
  InvertedListsOptions lists = {};
  InvertedMultiIndexOptions multi_index = {};
  KdTreeOptions kd_tree = {};
};

// What makes the engine search its tiles by this method. Throws Error(kInvalidArgument) on options
// that are out of range.
IndexOptions MakeIndexOptions(IndexMethod method, const IndexMethodOptions& options = {});

}  // namespace cairn

#endif  // CAIRN_LAB_RIVALS_INDEX_INDEX_METHODS_H_
