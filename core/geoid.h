// Heights above mean sea level as heights above the WGS84 ellipsoid, which is what Cairn computes
// in.
#ifndef CAIRN_CORE_GEOID_H_
#define CAIRN_CORE_GEOID_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/geodesy.h"

namespace cairn {

// What a height is measured from.
enum class HeightReference {
  kEllipsoid,     // WGS84's: Android's Location, W3C's Geolocation, survey receivers, our maps.
  kMeanSeaLevel,  // The geoid: EXIF, iOS, topographic maps.
};

// "ellipsoid" or "msl".
const char* HeightReferenceName(HeightReference reference);
std::optional<HeightReference> HeightReferenceFromName(std::string_view name);

// A global grid of the height of the geoid above the ellipsoid. Immutable; safe to use from any
// thread.
class Geoid {
 public:
  // Reads a grid in the GTX format of NOAA's VDatum that covers the Earth. Throws
  // Error(kUnavailable) if the file is missing or cannot be read, Error(kBadInput) if it is no such
  // grid.
  explicit Geoid(const std::string& gtx_path);

  // EGM96, from PROJ's data files; read at the first call. Throws as the constructor.
  static const Geoid& Egm96();

  // Height of the geoid above the ellipsoid, metres: about +36 in Lund, -34 in Philadelphia.
  // Bicubic between the points of the grid; EGM96 itself is within about a metre of mean sea level.
  double HeightM(double lat_rad, double lon_rad) const;

 private:
  double At(int row, int column) const;

  int num_rows_ = 0, num_columns_ = 0;  // South to north, west to east, all around.
  double west_deg_ = 0.0;
  double step_deg_ = 0.0;
  std::vector<float> heights_m_;
};

// The same place with its height above the ellipsoid. Throws as Geoid::Egm96 if the reference is
// mean sea level.
Geodetic WithEllipsoidalHeight(const Geodetic& position, HeightReference reference);

}  // namespace cairn

#endif  // CAIRN_CORE_GEOID_H_
