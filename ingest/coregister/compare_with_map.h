// Compares the placement of a session with the map: the engine localizes photos of the session.
#ifndef CAIRN_INGEST_COREGISTER_COMPARE_WITH_MAP_H_
#define CAIRN_INGEST_COREGISTER_COMPARE_WITH_MAP_H_

#include <vector>

#include "core/rigid3.h"
#include "ingest/coregister/fit_placement.h"
#include "ingest/sfm/reconstruction.h"
#include "ingest/tiling/placed_session.h"
#include "storage/map/map_store.h"

namespace cairn {

// The result of the comparison.
struct MapComparison {
  int num_expected = 0;   // Queries that the map should recognize.
  int num_localized = 0;  // Of these, the queries that the map recognized.
  PlacementFit fit;       // Of the recognized queries; meaningful if there are any.
};

// Returns the images of the session that CompareWithMap localizes: up to 60 that the map should
// recognize, evenly over the session. The map should recognize a photo near which one of its own
// photos looks the same way (ingest/tiling/near_view.h).
std::vector<int> ImagesToCompare(const PlacedSession& session, const MapStore& map);

// Localizes photos of the session that stand near photos of the map, by the features of the
// reconstruction: raw, or in the projected space of the map's codebook. A session that is misplaced
// by more than 15 m is not found. The result depends only on the map's latest version. Throws what
// the engine throws on a damaged map.
MapComparison CompareWithMap(const Reconstruction& reconstruction, const PlacedSession& session,
                             const MapStore& map);

}  // namespace cairn

#endif  // CAIRN_INGEST_COREGISTER_COMPARE_WITH_MAP_H_
