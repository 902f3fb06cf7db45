#include "engine/tiles/tile_cache.h"

#include <string>
#include <tuple>

namespace cairn {
namespace {

auto KeyOf(const IndexOptions& index) {
  const RandomGridsOptions& grids = index.grids;
  const InvertedListsOptions& lists = index.lists;
  return std::tuple(index.kind, index.num_reference_words, grids.num_grids, grids.num_hashed_dims,
                    grids.cell_width_sigmas, grids.num_probes, grids.max_candidates_per_cell,
                    grids.seed, lists.num_lists, lists.num_probes, lists.num_iterations, lists.seed,
                    index.other ? index.other->name() : std::string());
}

}  // namespace

bool TileCache::IndexesAs(const IndexOptions& options) const {
  return KeyOf(index_options_) == KeyOf(options);
}

}  // namespace cairn
