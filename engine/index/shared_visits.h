// The cells that queries visit, worked out for the index of one tile and used for others.
#ifndef CAIRN_ENGINE_INDEX_SHARED_VISITS_H_
#define CAIRN_ENGINE_INDEX_SHARED_VISITS_H_

#include <map>
#include <utility>
#include <vector>

#include "engine/index/cell_lists.h"

namespace cairn {

// Where a query looks in a grid depends on the codebook and the options, not on the tile. One
// object serves the searches for the same queries in tiles of one codebook by indexes of the same
// options. For use within one thread.
class SharedVisits {
 public:
  // The visits to a grid whose cells are hashed into 2^num_bucket_bits buckets: make() if nobody
  // has asked for them before. Valid as long as this.
  template <typename Make>
  const std::vector<CellVisit>& OfGrid(int grid, int num_bucket_bits, const Make& make) {
    const auto [entry, is_new] = of_grid_.try_emplace({grid, num_bucket_bits});
    if (is_new) {
      entry->second = make();
    }
    return entry->second;
  }

 private:
  std::map<std::pair<int, int>, std::vector<CellVisit>> of_grid_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_SHARED_VISITS_H_
