// The rigid motion that moves a session to where the map sees its cameras.
#ifndef CAIRN_INGEST_COREGISTER_FIT_PLACEMENT_H_
#define CAIRN_INGEST_COREGISTER_FIT_PLACEMENT_H_

#include <vector>

#include "core/rigid3.h"

namespace cairn {

// One camera, placed by its session and by the map.
struct PosePair {
  Rigid3d cam_from_ecef;         // As the session has it.
  Rigid3d cam_from_ecef_in_map;  // As the map has it.
};

// How the two placements of the cameras differ.
struct PlacementFit {
  Rigid3d map_from_session;  // Moves positions, ECEF.
  double moved_m = 0.0;      // At the middle of the cameras.
  double turned_rad = 0.0;
  double scale = 1.0;    // Size of the session in the map over its size in the session.
  int num_agreeing = 0;  // Cameras within max_residual_m and max_residual_rad after the motion,
  double median_residual_m = 0.0;  // and their median distance.
};

struct PlacementFitOptions {
  double max_residual_m = 1.0;
  double max_residual_rad = 0.087;  // 5 degrees.
};

// Robust least squares over positions and orientations, linear in a small rotation about the middle
// of the cameras, a translation and a change of size; needs at least one pair. `map_from_session`
// is without the change of size, which is reported only. Deterministic.
PlacementFit FitPlacement(const std::vector<PosePair>& pairs, const PlacementFitOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_COREGISTER_FIT_PLACEMENT_H_
