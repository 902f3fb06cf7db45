#include "engine/matching/index_options.h"

#include "core/check.h"
#include "core/require.h"
#include "engine/matching/probe_sequence.h"

namespace cairn {

void RandomGridsOptions::Validate() const {
  RequireWithin("matching.index.grids.num_grids", num_grids, 1, 64);
  RequireWithin("matching.index.grids.num_hashed_dims", num_hashed_dims, 1, 128);
  RequireWithin("matching.index.grids.cell_width_sigmas", cell_width_sigmas, 1e-3, 1e3);
  RequireWithin("matching.index.grids.num_probes", num_probes, 1, kMaxProbes);
  RequireWithin("matching.index.grids.max_candidates_per_cell", max_candidates_per_cell, 1, 10'000);
}

void InvertedListsOptions::Validate() const {
  RequireWithin("matching.index.lists.num_lists", num_lists, 1, 65'536);
  RequireWithin("matching.index.lists.num_probes", num_probes, 1, 65'536);
  RequireWithin("matching.index.lists.num_iterations", num_iterations, 0, 100);
}

void InvertedMultiIndexOptions::Validate() const {
  RequireWithin("matching.index.multi_index.num_words", num_words, 1, 4'096);
  RequireWithin("matching.index.multi_index.num_probes", num_probes, 1, 1'000'000);
  RequireWithin("matching.index.multi_index.num_iterations", num_iterations, 0, 100);
}

void KdTreeOptions::Validate() const {
  RequireWithin("matching.index.kd_tree.max_leaf_size", max_leaf_size, 1, 100'000);
  RequireWithin("matching.index.kd_tree.num_probes", num_probes, 1, 1'000'000);
}

void IndexOptions::Validate() const {
  grids.Validate();
  lists.Validate();
  multi_index.Validate();
  kd_tree.Validate();
  RequireWithin("matching.index.num_reference_words", num_reference_words, 0, 4'096);
}

const char* IndexKindName(IndexKind kind) {
  switch (kind) {
    case IndexKind::kRandomGrids:
      return "random_grids";
    case IndexKind::kInvertedLists:
      return "inverted_lists";
    case IndexKind::kInvertedMultiIndex:
      return "inverted_multi_index";
    case IndexKind::kKdTree:
      return "kd_tree";
    case IndexKind::kExhaustive:
      return "exhaustive";
  }
  CAIRN_CHECK(false, "an IndexKind has a name");
  return "";
}

}  // namespace cairn
