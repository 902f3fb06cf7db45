// Whether a session and the map agree on where its photos were taken. The engine localizes the
// photos of the session in the map.
#ifndef CAIRN_INGEST_COREGISTER_COMPARE_WITH_MAP_H_
#define CAIRN_INGEST_COREGISTER_COMPARE_WITH_MAP_H_

#include "core/rigid3.h"
#include "ingest/coregister/fit_placement.h"
#include "ingest/sfm/reconstruction.h"
#include "ingest/tiling/placed_session.h"
#include "storage/map/map_store.h"

namespace cairn {

struct ComparisonOptions {
  int max_queries = 60;  // Photos that are localized, evenly over the session.
  double search_radius_m =
      15;  // Accuracy of the priors; a session that is off by more is not found.
  // A photo should be recognised where a photo of the map was taken within this distance and this
  // angle.
  double near_m = 8.0;
  double near_rad = 0.7;

  void Validate() const;
};

// What the map says about a session's placement.
struct MapComparison {
  int num_expected = 0;   // Photos of those asked for that the map should recognise,
  int num_localized = 0;  // and those that it recognised.
  PlacementFit fit;       // Of these; meaningful if there are any.
};

// Localizes photos of the session that stand near photos of the map; their features are all that
// the reconstruction has. The answer depends on the map's current version only. Throws what the
// engine throws on a damaged map.
MapComparison CompareWithMap(const Reconstruction& reconstruction, const PlacedSession& session,
                             const MapStore& map, const ComparisonOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_COREGISTER_COMPARE_WITH_MAP_H_
