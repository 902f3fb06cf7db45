// Finds the motion from the session's placement of cameras to the map's.
#ifndef CAIRN_INGEST_PLACE_FIT_PLACEMENT_H_
#define CAIRN_INGEST_PLACE_FIT_PLACEMENT_H_

#include <vector>

#include "core/rigid3.h"
#include "ingest/anchor/pose_pair.h"

namespace cairn {

// The difference between the two placements of the cameras.
struct PlacementFit {
  Sim3d map_from_session;  // Moves positions, ECEF.
  double moved_m = 0.0;    // At the middle of the cameras.
  double raised_m = 0.0;   // Of these, upward; negative is downward.
  double turned_rad = 0.0;
  double scale = 1.0;              // Size of the session by the map over its size by the session.
  int num_agreeing = 0;            // Cameras within the largest residuals after the motion.
  double median_residual_m = 0.0;  // Median distance of the agreeing cameras.
  std::vector<bool> agrees;        // Of each pair: whether its camera agrees.
  // The radius that holds 68 % of the agreeing cameras' distances together with their accuracies,
  // in quadrature: how far session and map disagree beside the errors of single poses.
  double disagreement_m = 0.0;
};

struct PlacementFitOptions {
  double max_residual_m = 1.0;
  double max_residual_rad = 0.087;  // 5 degrees.
};

// Fits a rotation about the middle of the cameras, a translation and a change of size to positions
// and orientations, by robust linear least squares about a start. The start is no motion at all. If
// fewer than half of the cameras agree on the result, the motions of single cameras are starts as
// well, so that a session that is turned around or far away is found, too. The fit on which most
// cameras agree wins. Needs at least one pair. Takes quadratic time in the pairs. Deterministic.
PlacementFit FitPlacement(const std::vector<PosePair>& pairs, const PlacementFitOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_FIT_PLACEMENT_H_
