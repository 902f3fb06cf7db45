#include "core/geodesy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/angles.h"
#include "core/error.h"

namespace cairn {
namespace {

bool BoxContains(const GeoBox& box, double lat_rad, double lon_rad) {
  if (lat_rad < box.south_rad || lat_rad > box.north_rad) {
    return false;
  }
  return box.CrossesAntimeridian() ? lon_rad >= box.west_rad || lon_rad <= box.east_rad
                                   : lon_rad >= box.west_rad && lon_rad <= box.east_rad;
}

TEST(Geodesy, KnowsPointsOnTheAxes) {
  EXPECT_LT(
      (EcefFromGeodetic(Geodetic::FromDegrees(0, 0, 0)) - Eigen::Vector3d(6378137.0, 0.0, 0.0))
          .norm(),
      1e-6);
  EXPECT_LT((EcefFromGeodetic(Geodetic::FromDegrees(90, 0, 10)) -
             Eigen::Vector3d(0.0, 0.0, 6356752.314245 + 10.0))
                .norm(),
            1e-5);
}

TEST(Geodesy, GeodeticSurvivesEcef) {
  const Geodetic there = Geodetic::FromDegrees(-33.9, 151.2, 87.0);
  const Geodetic back = GeodeticFromEcef(EcefFromGeodetic(there));
  EXPECT_NEAR(back.lat_rad, there.lat_rad, 1e-14);
  EXPECT_NEAR(back.lon_rad, there.lon_rad, 1e-14);
  EXPECT_NEAR(back.h_m, there.h_m, 1e-8);
}

TEST(Geodesy, EnuAxesPointEastNorthUp) {
  const Geodetic origin = Geodetic::FromDegrees(47.4, 8.5, 400.0);
  const Rigid3d ecef_from_enu = EcefFromEnu(origin);
  const Geodetic east = GeodeticFromEcef(ecef_from_enu * Eigen::Vector3d(100, 0, 0));
  const Geodetic north = GeodeticFromEcef(ecef_from_enu * Eigen::Vector3d(0, 100, 0));
  const Geodetic up = GeodeticFromEcef(ecef_from_enu * Eigen::Vector3d(0, 0, 100));
  EXPECT_GT(east.lon_rad, origin.lon_rad);
  EXPECT_NEAR(GroundDistanceM(origin, east), 100.0, 0.01);
  EXPECT_GT(north.lat_rad, origin.lat_rad);
  EXPECT_NEAR(GroundDistanceM(origin, north), 100.0, 0.01);
  EXPECT_NEAR(up.h_m, 500.0, 1e-6);
}

TEST(Geodesy, BoxAroundHoldsTheDisc) {
  for (const double lat_deg : {0.0, 47.0, -70.0, 89.9}) {
    for (const double lon_deg : {8.0, 179.9999}) {
      const Geodetic center = Geodetic::FromDegrees(lat_deg, lon_deg, 0.0);
      const GeoBox box = BoxAround(center, 250.0);
      const Rigid3d ecef_from_enu = EcefFromEnu(center);
      for (double angle_rad = 0.0; angle_rad < 6.3; angle_rad += 0.1) {
        const Geodetic edge =
            GeodeticFromEcef(ecef_from_enu * Eigen::Vector3d(250 * std::cos(angle_rad),
                                                             250 * std::sin(angle_rad), 0));
        EXPECT_TRUE(BoxContains(box, edge.lat_rad, edge.lon_rad)) << lat_deg << " " << lon_deg;
      }
    }
  }
}

TEST(Geodesy, BoxAroundIsTight) {
  const Geodetic center = Geodetic::FromDegrees(47.0, 8.0, 0.0);
  const GeoBox box = BoxAround(center, 250.0);
  const Geodetic north{box.north_rad, center.lon_rad, 0.0};
  const Geodetic east{center.lat_rad, box.east_rad, 0.0};
  EXPECT_LT(GroundDistanceM(center, north), 255.0);
  EXPECT_LT(GroundDistanceM(center, east), 255.0);
}

TEST(Geodesy, BoxAroundPoleSpansAllLongitudes) {
  const GeoBox box = BoxAround(Geodetic::FromDegrees(89.9999, 10.0, 0.0), 100.0);
  EXPECT_DOUBLE_EQ(box.west_rad, -kPi);
  EXPECT_DOUBLE_EQ(box.east_rad, kPi);
  EXPECT_DOUBLE_EQ(box.north_rad, 0.5 * kPi);
}

TEST(Geodesy, RefusesPositionsOffTheEarth) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NO_THROW(ValidateGeodetic(Geodetic::FromDegrees(90, -180, 0), "p"));
  EXPECT_THROW(ValidateGeodetic(Geodetic::FromDegrees(91, 0, 0), "p"), Error);
  EXPECT_THROW(ValidateGeodetic(Geodetic::FromDegrees(0, 181, 0), "p"), Error);
  EXPECT_THROW(ValidateGeodetic(Geodetic::FromDegrees(nan, 0, 0), "p"), Error);
  EXPECT_THROW(ValidateGeodetic(Geodetic::FromDegrees(0, 0, nan), "p"), Error);
  EXPECT_THROW(ValidateGeodetic(Geodetic::FromDegrees(0, 0, 1e6), "p"), Error);
}

}  // namespace
}  // namespace cairn
