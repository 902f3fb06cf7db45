// Places a reconstruction on Earth: robust similarity to camera positions.
#ifndef CAIRN_INGEST_GEOREGISTER_GEOREGISTER_H_
#define CAIRN_INGEST_GEOREGISTER_GEOREGISTER_H_

#include <string>
#include <vector>

#include "core/geodesy.h"
#include "core/geoid.h"
#include "core/rigid3.h"
#include "ingest/sfm/reconstruction.h"

namespace cairn {

// A known camera position.
struct CameraPosition {
  std::string image_name;
  Geodetic position;        // Georegister takes the height as ellipsoidal.
  double accuracy_m = 5.0;  // 68 %.
};

// CSV with a header; columns image, lat_deg, lon_deg, h_m and optionally accuracy_m, in any order.
// Throws Error(kBadInput) naming file, line and column.
std::vector<CameraPosition> ReadCameraPositions(const std::string& path);

// The GPS priors of the reconstruction's images, with one accuracy for all. Heights are as they
// came; those of EXIF are above mean sea level.
std::vector<CameraPosition> GpsPositions(const Reconstruction& reconstruction, double accuracy_m);

// Turns heights above `reference` into heights above the ellipsoid. Throws as
// WithEllipsoidalHeight.
void MakeHeightsEllipsoidal(HeightReference reference, std::vector<CameraPosition>* positions);

struct GeoregisterOptions {
  int min_positions = 3;
  // Robust loss scale in units of each position's accuracy.
  double loss_scale_sigmas = 2.0;
  // Camera positions along a line leave the roll about it free, and GPS heights are poor: people
  // and rigs hold cameras upright, so the image x axis is taken as horizontal with this standard
  // deviation, radians; 0 switches it off.
  double upright_sigma_rad = 0.1;
  // Refused above: the median residual in units of the accuracy, and in metres.
  double max_median_residual_sigmas = 3.0;
  double max_median_residual_m = 20.0;

  void Validate() const;
};

struct Georegistration {
  Sim3d ecef_from_world;
  int num_positions = 0;  // With an image in the reconstruction.
  int num_inliers = 0;    // Within three times the loss scale.
  double median_residual_m = 0.0;
  double max_residual_m = 0.0;
  std::vector<double> residuals_m;  // Per position used, in input order.
};

// Throws Error(kBadInput) with counts and residuals if too few positions match, if they do not
// determine a similarity (all at one place), or if the fit is bad.
Georegistration Georegister(const Reconstruction& reconstruction,
                            const std::vector<CameraPosition>& positions,
                            const GeoregisterOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_GEOREGISTER_GEOREGISTER_H_
