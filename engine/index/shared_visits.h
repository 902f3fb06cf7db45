// The visits of queries to cells, computed for the index of one tile and reused for other tiles.
#ifndef CAIRN_ENGINE_INDEX_SHARED_VISITS_H_
#define CAIRN_ENGINE_INDEX_SHARED_VISITS_H_

#include <map>
#include <utility>
#include <vector>

#include "engine/index/cell_lists.h"

namespace cairn {

// The visits of a query to a grid depend on the codebook and the options, not on the tile. One
// object serves searches for the same queries in tiles with the same codebook and indices with the
// same options. Use each object from one thread.
class SharedVisits {
 public:
  // Returns the visits to a grid whose cells are hashed into 2^num_bucket_bits buckets. Calls
  // make() if the visits were not requested before. Valid as long as this object.
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
