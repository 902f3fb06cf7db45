// Places a reconstruction on Earth by a robust similarity to known camera positions.
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
  Geodetic position;        // Georegister expects ellipsoidal heights.
  double accuracy_m = 5.0;  // 68 % radius.
};

// Reads a CSV with a header and the columns image, lat_deg, lon_deg, h_m and optionally accuracy_m,
// in any order. Throws Error(kBadInput) that names file, line and column.
std::vector<CameraPosition> ReadCameraPositions(const std::string& path);

// The GPS priors of the reconstruction's images, with the same accuracy for all. Heights are
// unchanged; EXIF heights are above mean sea level.
std::vector<CameraPosition> GpsPositions(const Reconstruction& reconstruction, double accuracy_m);

// Converts heights above `reference` to heights above the ellipsoid. Throws as
// WithEllipsoidalHeight.
void MakeHeightsEllipsoidal(HeightReference reference, std::vector<CameraPosition>* positions);

struct GeoregisterOptions {
  // Standard deviation in radians of the prior that image x axes are horizontal; 0 switches the
  // prior off. The prior is needed because camera positions along a line leave the roll about the
  // line free, and because GPS heights are poor. People and rigs hold cameras upright.
  double upright_sigma_rad = 0.1;
  // A fit is refused if its median residual exceeds one of these limits: in units of the accuracy,
  // or in meters.
  double max_median_residual_sigmas = 3.0;
  double max_median_residual_m = 20.0;

  void Validate() const;
};

struct Georegistration {
  Sim3d ecef_from_world;
  int num_positions = 0;  // Positions whose image is in the reconstruction.
  int num_inliers = 0;    // Positions within six times their accuracy.
  double median_residual_m = 0.0;
  double max_residual_m = 0.0;
  std::vector<double> residuals_m;  // One for each used position, in input order.
};

// Throws Error(kBadInput), with counts and residuals, if too few positions match, if the positions
// do not determine a similarity (all at one place), or if the fit is bad.
Georegistration Georegister(const Reconstruction& reconstruction,
                            const std::vector<CameraPosition>& positions,
                            const GeoregisterOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_GEOREGISTER_GEOREGISTER_H_
