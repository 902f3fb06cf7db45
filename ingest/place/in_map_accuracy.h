// Estimates how far parts of a reconstruction disagree with each other.
#ifndef CAIRN_INGEST_PLACE_IN_MAP_ACCURACY_H_
#define CAIRN_INGEST_PLACE_IN_MAP_ACCURACY_H_

#include <optional>
#include <vector>

#include "core/scene/reconstruction.h"
#include "ingest/tiles/placed_session.h"

namespace cairn {

// Where a photo stands by landmarks that other photos see, compared with where it stands in the
// reconstruction.
struct PhotoDisagreement {
  double error_m = 0.0;      // Distance of the two places.
  double predicted_m = 0.0;  // The calibrated 68 % radius that the matches predict for the error.
};

// Returns the radius that the errors have beside the predicted ones, in quadrature, so that 68 % of
// the errors are within both: the error of poses that no single match shows, because the errors of
// neighboring landmarks are alike. Zero if the predicted radii hold 68 %, or if there are no
// photos.
double UnpredictedRadius68(const std::vector<PhotoDisagreement>& photos);

// Places up to 40 photos, evenly over the session, again: each by halves of its landmarks, which
// are triangulated without the photo (at most 400). `scale` is meters per unit of the
// reconstruction. Returns nothing if fewer than 5 photos have 24 landmarks that two other photos
// see. Deterministic.
std::optional<double> EstimateInMapAccuracy(const Reconstruction& reconstruction,
                                            const PlacedSession& session, double scale);

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_IN_MAP_ACCURACY_H_
