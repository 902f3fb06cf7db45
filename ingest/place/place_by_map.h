// Places a reconstruction where a map sees its photos, if its positions do not place it.
#ifndef CAIRN_INGEST_PLACE_PLACE_BY_MAP_H_
#define CAIRN_INGEST_PLACE_PLACE_BY_MAP_H_

#include <optional>
#include <vector>

#include "core/geodesy.h"
#include "core/rigid3.h"
#include "core/scene/reconstruction.h"
#include "ingest/place/known_tiles.h"

namespace cairn {

struct PlacementByMap {
  // From the reconstruction's units to meters. Nothing unless three photos, and half of the
  // recognized ones, agree.
  std::optional<Sim3d> ecef_from_world;
  int num_asked = 0;
  int num_recognized = 0;          // With a confidence of 0.9.
  int num_agreeing = 0;            // Within 1 m and 5 degrees of where the map sees them.
  double median_residual_m = 0.0;  // Of those that agree.
};

// Localizes at most 24 photos, evenly over those with a rough position, by the features of the
// reconstruction. `rough_positions` has a member for each image, with heights above the ellipsoid;
// the engine searches within 100 m of them. The map decides place, direction, tilt and scale: up
// may be unknown, too. The result follows the largest group of answers, and CompareWithMap has to
// confirm it. It does not depend on `num_threads`. Throws what the engine throws on a damaged map.
PlacementByMap PlaceByMap(const Reconstruction& reconstruction,
                          const std::vector<std::optional<Geodetic>>& rough_positions,
                          const KnownTiles& map, int num_threads);

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_PLACE_BY_MAP_H_
