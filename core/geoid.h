// Converts heights above mean sea level to heights above the WGS84 ellipsoid, which Cairn uses for
// all computations.
#ifndef CAIRN_CORE_GEOID_H_
#define CAIRN_CORE_GEOID_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/geodesy.h"

namespace cairn {

// The surface from which a height is measured.
enum class HeightReference {
  kEllipsoid,     // WGS84: Android's Location, W3C's Geolocation, survey receivers, Cairn's maps.
  kMeanSeaLevel,  // The geoid: EXIF, iOS, topographic maps.
};

// "ellipsoid" or "msl".
const char* HeightReferenceName(HeightReference reference);
std::optional<HeightReference> HeightReferenceFromName(std::string_view name);

// A global grid of geoid heights above the ellipsoid. Immutable; safe to use from any thread.
class Geoid {
 public:
  // Reads a grid in the GTX format of NOAA's VDatum that covers the Earth. Throws
  // Error(kUnavailable) if the file is missing or cannot be read, and Error(kBadInput) if it is not
  // such a grid.
  explicit Geoid(const std::string& gtx_path);

  // Returns EGM96 from PROJ's data files, read at the first call. Throws what the constructor
  // throws.
  static const Geoid& Egm96();

  // Returns the height of the geoid above the ellipsoid, meters: about +36 in Lund, -34 in
  // Philadelphia. Interpolates bicubically between grid points. EGM96 itself is within about a
  // meter of mean sea level.
  double HeightM(double lat_rad, double lon_rad) const;

 private:
  double At(int row, int column) const;

  int num_rows_ = 0, num_columns_ = 0;  // South to north; west to east, all around the Earth.
  double west_deg_ = 0.0;
  double step_deg_ = 0.0;
  std::vector<float> heights_m_;
};

// Returns the same place with its height above the ellipsoid. Throws what Geoid::Egm96 throws if
// the reference is mean sea level.
Geodetic WithEllipsoidalHeight(const Geodetic& position, HeightReference reference);

}  // namespace cairn

#endif  // CAIRN_CORE_GEOID_H_
