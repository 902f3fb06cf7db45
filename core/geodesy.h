// WGS84 positions and local frames, computed by GeographicLib.
#ifndef CAIRN_CORE_GEODESY_H_
#define CAIRN_CORE_GEODESY_H_

#include <Eigen/Core>

#include "core/rigid3.h"

namespace cairn {

// A WGS84 position. The height is above the ellipsoid.
struct Geodetic {
  double lat_rad = 0.0;  // [-pi/2, pi/2]
  double lon_rad = 0.0;  // [-pi, pi)
  double h_m = 0.0;

  static constexpr double kMinHeightM = -12e3, kMaxHeightM = 100e3;  // Of ValidateGeodetic.

  static Geodetic FromDegrees(double lat_deg, double lon_deg, double h_m);
  double lat_deg() const;
  double lon_deg() const;
};

// Throws Error(kBadInput), naming `what`, unless latitude and longitude are finite and in range and
// the height lies within [-12 km, 100 km].
void ValidateGeodetic(const Geodetic& position, const char* what);

Eigen::Vector3d EcefFromGeodetic(const Geodetic& position);
Geodetic GeodeticFromEcef(const Eigen::Vector3d& x_in_ecef);

// Returns the east-north-up frame at `origin`.
Rigid3d EcefFromEnu(const Geodetic& origin);

// Returns the great-ellipse distance on the ground, meters; heights are ignored. Accurate to
// centimeters below 100 km.
double GroundDistanceM(const Geodetic& a, const Geodetic& b);

// A latitude-longitude box in radians. If west > east, the box crosses the antimeridian.
struct GeoBox {
  double south_rad = 0.0, west_rad = 0.0, north_rad = 0.0, east_rad = 0.0;

  bool CrossesAntimeridian() const { return west_rad > east_rad; }
};

// Returns the smallest box that contains the disc of `radius_m` around `center`. The box spans all
// longitudes if the disc contains a pole.
GeoBox BoxAround(const Geodetic& center, double radius_m);

GeoBox WholeEarth();

}  // namespace cairn

#endif  // CAIRN_CORE_GEODESY_H_
