#include "core/geodesy.h"

#include <fmt/format.h>

#include <GeographicLib/Constants.hpp>
#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/Geodesic.hpp>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/angles.h"
#include "core/error.h"

namespace cairn {
namespace {

const GeographicLib::Geocentric& Earth() { return GeographicLib::Geocentric::WGS84(); }

}  // namespace

Geodetic Geodetic::FromDegrees(double lat_deg, double lon_deg, double h_m) {
  return {lat_deg / kDegPerRad, lon_deg / kDegPerRad, h_m};
}

double Geodetic::lat_deg() const { return lat_rad * kDegPerRad; }
double Geodetic::lon_deg() const { return lon_rad * kDegPerRad; }

void ValidateGeodetic(const Geodetic& position, const char* what) {
  const double lat_deg = position.lat_deg();
  const double lon_deg = position.lon_deg();
  constexpr double kSlackDeg = 1e-9;  // Allows for rounding in the conversion from degrees.
  if (!(std::abs(lat_deg) <= 90.0 + kSlackDeg)) {
    const bool is_swapped = std::abs(lat_deg) <= 180.0 && std::abs(lon_deg) <= 90.0;
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: latitude {} is not within [-90, 90] degrees{}", what, lat_deg,
                            is_swapped ? "; have latitude and longitude changed places?" : ""));
  }
  if (!(std::abs(lon_deg) <= 180.0 + kSlackDeg)) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: longitude {} is not within [-180, 180] degrees", what, lon_deg));
  }
  if (!(position.h_m >= Geodetic::kMinHeightM && position.h_m <= Geodetic::kMaxHeightM)) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: height {} is not within [-12000, 100000] m", what, position.h_m));
  }
}

Eigen::Vector3d EcefFromGeodetic(const Geodetic& position) {
  Eigen::Vector3d x_in_ecef;
  Earth().Forward(position.lat_deg(), position.lon_deg(), position.h_m, x_in_ecef.x(),
                  x_in_ecef.y(), x_in_ecef.z());
  return x_in_ecef;
}

Geodetic GeodeticFromEcef(const Eigen::Vector3d& x_in_ecef) {
  double lat_deg = 0.0, lon_deg = 0.0, h_m = 0.0;
  Earth().Reverse(x_in_ecef.x(), x_in_ecef.y(), x_in_ecef.z(), lat_deg, lon_deg, h_m);
  return Geodetic::FromDegrees(lat_deg, lon_deg, h_m);
}

Rigid3d EcefFromEnu(const Geodetic& origin) {
  std::vector<double> rotation(9);
  Eigen::Vector3d origin_in_ecef;
  Earth().Forward(origin.lat_deg(), origin.lon_deg(), origin.h_m, origin_in_ecef.x(),
                  origin_in_ecef.y(), origin_in_ecef.z(), rotation);
  const Eigen::Matrix3d ecef_from_enu =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation.data());
  return {ecef_from_enu, origin_in_ecef};
}

double GroundDistanceM(const Geodetic& a, const Geodetic& b) {
  double distance_m = 0.0;
  GeographicLib::Geodesic::WGS84().Inverse(a.lat_deg(), a.lon_deg(), b.lat_deg(), b.lon_deg(),
                                           distance_m);
  return distance_m;
}

GeoBox WholeEarth() { return {-0.5 * kPi, -kPi, 0.5 * kPi, kPi}; }

GeoBox BoxAround(const Geodetic& center, double radius_m) {
  constexpr double kHalfPi = 0.5 * kPi;
  // The radius is the smallest radius of curvature of the ellipsoid, b^2 / a (the meridian's at the
  // equator), so that the box is never too small.
  const double equatorial_m = GeographicLib::Constants::WGS84_a();
  const double polar_m = equatorial_m * (1.0 - GeographicLib::Constants::WGS84_f());
  const double reach_rad = radius_m / (polar_m * polar_m / equatorial_m);
  GeoBox box{center.lat_rad - reach_rad, -kPi, center.lat_rad + reach_rad, kPi};
  const bool contains_pole = box.north_rad >= kHalfPi || box.south_rad <= -kHalfPi;
  box.south_rad = std::max(box.south_rad, -kHalfPi);
  box.north_rad = std::min(box.north_rad, kHalfPi);
  if (contains_pole) {
    return box;
  }
  // The largest longitude difference on a spherical cap.
  const double sine = std::sin(std::min(reach_rad, kHalfPi)) / std::cos(center.lat_rad);
  if (sine >= 1.0) {
    return box;
  }
  const double reach_lon_rad = std::asin(sine);
  if (reach_lon_rad >= kPi) {
    return box;
  }
  const auto wrap = [](double lon_rad) { return std::remainder(lon_rad, 2.0 * kPi); };
  box.west_rad = wrap(center.lon_rad - reach_lon_rad);
  box.east_rad = wrap(center.lon_rad + reach_lon_rad);
  return box;
}

}  // namespace cairn
