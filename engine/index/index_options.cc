#include "engine/index/index_options.h"

#include "core/require.h"
#include "engine/index/probe_sequence.h"

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

void IndexOptions::Validate() const {
  grids.Validate();
  lists.Validate();
  RequireOption((kind == IndexKind::kOther) == (other != nullptr),
                "matching.index.other must be set if and only if the kind is \"other\"");
  RequireWithin("matching.index.num_reference_words", num_reference_words, 0, 4'096);
}

}  // namespace cairn
