#include "core/geoid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "core/error.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

struct KnownHeight {
  const char* source;
  double lat_deg, lon_deg, geoid_m;
};

double GeoidM(double lat_deg, double lon_deg) {
  const Geodetic place = Geodetic::FromDegrees(lat_deg, lon_deg, 0.0);
  return Geoid::Egm96().HeightM(place.lat_rad, place.lon_rad);
}

// The NGA's values are those of its test file for the 15 minute grid (OUTINTPT.DAT); the others
// were computed by other programs from EGM96, to the digits given.
TEST(Geoid, HasThePublishedHeightsOfEgm96) {
  const std::vector<KnownHeight> known = {
      {"NGA", 38.6281550, 269.7791550, -31.628},
      {"NGA", -14.6212170, 305.0211140, -2.969},
      {"NGA", 46.8743190, 102.4487290, -43.575},
      {"NGA", -23.6174460, 133.8747120, 15.871},
      {"NGA", 38.6254730, 359.9995000, 50.066},
      {"NGA", -0.4667440, 0.0023000, 17.329},
      {"GeographicLib's manual, Timbuktu", 16.0 + 46.0 / 60 + 33.0 / 3600,
       -(3.0 + 0.0 / 60 + 34.0 / 3600), 28.7068},
      {"MATLAB's manual, Mount Everest", 27.988056, 86.925278, -28.7444},
      {"MATLAB's manual, Maryland", 39.3, -77.2, -33.01},
      {"MATLAB's manual, Syria", 33.4, 36.5, 25.55},
      {"MATLAB's manual, Kyrgyzstan", 42.4, 71.0, -36.59},
  };
  for (const KnownHeight& place : known) {
    EXPECT_NEAR(GeoidM(place.lat_deg, place.lon_deg), place.geoid_m, 0.06)
        << place.source << ": " << place.lat_deg << ", " << place.lon_deg;
  }
}

TEST(Geoid, ReachesItsKnownExtremes) {
  EXPECT_NEAR(GeoidM(-8.25, 147.25), 85.4, 0.1);   // New Guinea.
  EXPECT_NEAR(GeoidM(4.75, 78.75), -107.0, 0.1);   // South of India.
  EXPECT_NEAR(GeoidM(55.705, 13.19), 35.7, 0.1);   // Lund.
  EXPECT_NEAR(GeoidM(39.95, -75.16), -34.2, 0.1);  // Philadelphia.
}

TEST(Geoid, HasNoSeamAtTheAntimeridianTheMeridianOfGreenwichAndThePoles) {
  constexpr double kStepDeg = 1e-7;
  for (const double lat_deg : {-89.99, -45.0, 0.0, 12.3, 89.99}) {
    EXPECT_NEAR(GeoidM(lat_deg, 180.0 - kStepDeg), GeoidM(lat_deg, -180.0 + kStepDeg), 1e-5);
    EXPECT_NEAR(GeoidM(lat_deg, -kStepDeg), GeoidM(lat_deg, kStepDeg), 1e-5);
    EXPECT_NEAR(GeoidM(lat_deg, 370.0), GeoidM(lat_deg, 10.0), 1e-9);
  }
  for (const double pole_deg : {-90.0, 90.0}) {
    for (double lon_deg = -180.0; lon_deg < 180.0; lon_deg += 7.0) {
      EXPECT_NEAR(GeoidM(pole_deg, lon_deg), GeoidM(pole_deg, 0.0), 1e-5);
      EXPECT_NEAR(GeoidM(0.999999 * pole_deg, lon_deg), GeoidM(pole_deg, 0.0), 0.01);
    }
  }
}

TEST(Geoid, AddsToHeightsAboveMeanSeaLevelOnly) {
  const Geodetic lund = Geodetic::FromDegrees(55.705, 13.19, 50.0);
  EXPECT_EQ(WithEllipsoidalHeight(lund, HeightReference::kEllipsoid).h_m, 50.0);
  const Geodetic converted = WithEllipsoidalHeight(lund, HeightReference::kMeanSeaLevel);
  EXPECT_NEAR(converted.h_m, 85.7, 0.1);
  EXPECT_EQ(converted.lat_rad, lund.lat_rad);
  EXPECT_EQ(converted.lon_rad, lund.lon_rad);
}

TEST(Geoid, NamesOfReferencesGoBothWays) {
  EXPECT_EQ(HeightReferenceFromName("msl"), HeightReference::kMeanSeaLevel);
  EXPECT_EQ(HeightReferenceFromName("ellipsoid"), HeightReference::kEllipsoid);
  EXPECT_EQ(HeightReferenceFromName("geoid"), std::nullopt);
}

TEST(Geoid, SaysWhatIsWrongWithTheGrid) {
  const testing::TempDir dir;
  const std::string path = dir.File("grid.gtx");
  const auto code_of = [&] {
    try {
      const Geoid geoid(path);
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("grid.gtx"), std::string::npos);
      return error.code();
    }
    return ErrorCode::kInternal;
  };
  EXPECT_EQ(code_of(), ErrorCode::kUnavailable);  // There is no such file.
  std::ofstream(path) << "GTX";
  EXPECT_EQ(code_of(), ErrorCode::kBadInput);
  std::ofstream(path) << std::string(40 + 4 * 16, '\xff');
  EXPECT_EQ(code_of(), ErrorCode::kBadInput);
}

}  // namespace
}  // namespace cairn
