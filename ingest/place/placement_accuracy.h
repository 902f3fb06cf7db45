// Estimates how far a georegistered reconstruction is from its true place on Earth.
#ifndef CAIRN_INGEST_PLACE_PLACEMENT_ACCURACY_H_
#define CAIRN_INGEST_PLACE_PLACEMENT_ACCURACY_H_

#include <Eigen/Core>
#include <vector>

namespace cairn {

// A known camera position after the fit.
struct FittedPosition {
  Eigen::Vector3d center_in_enu;
  Eigen::Vector3d residual_m;
  double accuracy_m = 1.0;  // As it was stated: a 68 % radius.
};

// 68 % radii (core/radius68.h) of the cameras' places and of the direction of the whole.
struct PlacementAccuracy {
  double position_m = 0.0;
  double rotation_rad = 0.0;
};

// `positions` are those that agree with the fit, at least one, in the order in which they were
// taken. Three things put a reconstruction off, in variances per axis:
//  - the fit follows the noise of the positions. A similarity has seven parameters, so the noise v
//    moves the cameras by v * 7 / 3n in the mean. Positions taken one after the other may share
//    errors. The means of stretches then vary more than by chance, and the noise counts the more;
//  - stretches stay off after the fit, because the reconstruction bends or the receiver drifts;
//  - all positions may share an error, which leaves no residual: as much of the stated accuracy as
//    the residuals do not show.
//
// The direction is as certain as the spread of the positions and, where it leaves a rotation open,
// the horizontal axes of the cameras make it: `upright_sigma_rad` is that of GeoregisterOptions.
PlacementAccuracy EstimatePlacementAccuracy(const std::vector<FittedPosition>& positions,
                                            double upright_sigma_rad);

// For a fit to positions alone. Throws Error(kBadInput) if they leave the direction open to more
// than 5 degrees: if they lie near a line, the roll about the line follows their errors.
void RequireKnownUp(const PlacementAccuracy& accuracy);

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_PLACEMENT_ACCURACY_H_
