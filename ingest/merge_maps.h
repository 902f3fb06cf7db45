// Two maps in one.
#ifndef CAIRN_INGEST_MERGE_MAPS_H_
#define CAIRN_INGEST_MERGE_MAPS_H_

#include <cstdint>
#include <functional>
#include <string>

#include "storage/map/map_store.h"

namespace cairn {

struct MergeReport {
  int64_t num_tiles_of_both = 0;  // Tiles that hold landmarks of both maps.
  MapTotals totals;               // Of the merged map.
};

// Creates the map `to` with the latest versions of both maps. Sessions, keyframes and landmarks get
// new ids. A tile of both maps holds the landmarks of both, unmerged and without a budget. The past
// versions stay behind. `progress` may be empty; it receives the number of tiles done and the
// total. Throws Error(kConflict) with the reason if the codebooks differ, if both maps have a
// session of the same name or of the same content, or if `to` exists. Throws Error(kBadInput) if
// the descriptors are of different types.
MergeReport MergeMaps(const MapStore& a, const MapStore& b, const std::string& to,
                      const std::function<void(int64_t, int64_t)>& progress);

}  // namespace cairn

#endif  // CAIRN_INGEST_MERGE_MAPS_H_
