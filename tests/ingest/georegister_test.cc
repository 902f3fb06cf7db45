#include "ingest/place/georegister.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <random>

#include "core/angles.h"
#include "core/error.h"
#include "core/frames.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;

// GPS of the street's cameras with noise, the heights three times as bad.
std::vector<CameraPosition> NoisyPositions(const Reconstruction& reconstruction, double noise_m) {
  std::mt19937_64 rng(7);
  std::normal_distribution<double> noise(0.0, noise_m);
  std::vector<CameraPosition> positions = GpsPositions(reconstruction, std::max(noise_m, 0.01));
  for (CameraPosition& position : positions) {
    const Rigid3d ecef_from_enu = EcefFromEnu(position.position);
    const double east_m = noise(rng), north_m = noise(rng), up_m = 3.0 * noise(rng);
    position.position = GeodeticFromEcef(ecef_from_enu * Eigen::Vector3d(east_m, north_m, up_m));
  }
  return positions;
}

// Largest angle between the true down and the down found, and largest error of a camera's place.
struct Errors {
  double tilt_deg = 0.0;
  double position_m = 0.0;
};
Errors ErrorsOf(const Sim3d& ecef_from_world, const testing::StreetWorld& world,
                const Reconstruction& reconstruction) {
  Errors errors;
  const Sim3d truth = world.EcefFromWorld();
  errors.tilt_deg = RotationAngleRad(ecef_from_world.rotation, truth.rotation) * kDegPerRad;
  for (const ReconImage& image : reconstruction.images) {
    const Eigen::Vector3d center = image.cam_from_world.Inverse().translation;
    errors.position_m =
        std::max(errors.position_m, (ecef_from_world * center - truth * center).norm());
  }
  return errors;
}

TEST(Georegister, PositionsAloneAreRefusedIfTheyLeaveTheRollOpen) {
  const testing::StreetWorld world;
  const Reconstruction reconstruction = world.Reconstruct();
  GeoregisterOptions alone;
  alone.up = UpSource::kPositions;
  EXPECT_THAT(
      [&] { Georegister(reconstruction, NoisyPositions(reconstruction, 1.0), alone); },
      ::testing::ThrowsMessage<Error>(HasSubstr("the positions alone tell which way is up")));
}

TEST(Georegister, RecoversTheSimilarityFromExactPositions) {
  const testing::StreetWorld world;
  const Reconstruction reconstruction = world.Reconstruct();
  const Georegistration result =
      Georegister(reconstruction, GpsPositions(reconstruction, 0.01), {});
  EXPECT_EQ(result.num_positions, 21);
  EXPECT_EQ(result.num_inliers, 21);
  EXPECT_LT(result.max_residual_m, 1e-3);
  EXPECT_NEAR(result.ecef_from_world.scale, world.EcefFromWorld().scale, 1e-4);
  const Errors errors = ErrorsOf(result.ecef_from_world, world, reconstruction);
  EXPECT_LT(errors.tilt_deg, 0.1);
  EXPECT_LT(errors.position_m, 1e-2);
}

TEST(Georegister, StaysLevelOnANearlyStraightStreetWithPoorHeights) {
  const testing::StreetWorld world({.length_m = 150.0});
  const Reconstruction reconstruction = world.Reconstruct();
  const Georegistration result =
      Georegister(reconstruction, NoisyPositions(reconstruction, 3.0), {});
  const Errors errors = ErrorsOf(result.ecef_from_world, world, reconstruction);
  EXPECT_LT(errors.tilt_deg, 4.0);
  EXPECT_LT(errors.position_m, 8.0);
}

TEST(Georegister, WithoutTheUprightPriorTheRollOfAStreetIsLost) {
  const testing::StreetWorld world({.length_m = 150.0});
  const Reconstruction reconstruction = world.Reconstruct();
  const std::vector<CameraPosition> positions = NoisyPositions(reconstruction, 3.0);
  GeoregisterOptions options;
  options.upright_sigma_rad = 0.0;
  options.max_median_residual_sigmas = 100.0;
  const double without = ErrorsOf(Georegister(reconstruction, positions, options).ecef_from_world,
                                  world, reconstruction)
                             .tilt_deg;
  const double with =
      ErrorsOf(Georegister(reconstruction, positions, {}).ecef_from_world, world, reconstruction)
          .tilt_deg;
  EXPECT_GT(without, 5.0 * with);
}

TEST(Georegister, OutlyingPositionsDoNotMatter) {
  const testing::StreetWorld world;
  const Reconstruction reconstruction = world.Reconstruct();
  std::vector<CameraPosition> positions = NoisyPositions(reconstruction, 0.1);
  for (const int i : {2, 9, 15}) {
    positions[i].position.lat_rad += 2e-5;  // 127 m.
  }
  const Georegistration result = Georegister(reconstruction, positions, {});
  EXPECT_GE(result.num_inliers, 15);
  EXPECT_LE(result.num_inliers, 18);
  EXPECT_LT(ErrorsOf(result.ecef_from_world, world, reconstruction).position_m, 0.5);
  EXPECT_GT(result.residuals_m[9], 100.0);
}

TEST(Georegister, IgnoresPositionsOfOtherImagesAndCountsTheRest) {
  const Reconstruction reconstruction = testing::StreetWorld().Reconstruct();
  std::vector<CameraPosition> positions = GpsPositions(reconstruction, 0.01);
  positions.push_back({"elsewhere.jpg", Geodetic::FromDegrees(10.0, 10.0, 0.0), 1.0});
  EXPECT_EQ(Georegister(reconstruction, positions, {}).num_positions, 21);
}

std::string RefusalOf(const Reconstruction& reconstruction,
                      const std::vector<CameraPosition>& positions,
                      const GeoregisterOptions& options = {}) {
  try {
    Georegister(reconstruction, positions, options);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kBadInput);
    return e.what();
  }
  return "no error";
}

TEST(Georegister, RefusesTooFewPositions) {
  const Reconstruction reconstruction = testing::StreetWorld().Reconstruct();
  std::vector<CameraPosition> positions = GpsPositions(reconstruction, 1.0);
  positions.resize(2);
  EXPECT_THAT(RefusalOf(reconstruction, positions), HasSubstr("2 of 2 known positions"));
}

TEST(Georegister, RefusesPositionsAtOnePlace) {
  const Reconstruction reconstruction = testing::StreetWorld().Reconstruct();
  std::vector<CameraPosition> positions = GpsPositions(reconstruction, 5.0);
  for (CameraPosition& position : positions) {
    position.position = positions[0].position;
  }
  EXPECT_THAT(RefusalOf(reconstruction, positions), HasSubstr("do not determine the scale"));
}

TEST(Georegister, RefusesPositionsThatDoNotBelongToTheImages) {
  const Reconstruction reconstruction = testing::StreetWorld().Reconstruct();
  std::vector<CameraPosition> positions = GpsPositions(reconstruction, 0.5);
  std::mt19937_64 rng(3);
  std::shuffle(positions.begin(), positions.end(), rng);
  for (size_t i = 0; i < positions.size(); ++i) {
    positions[i].image_name = reconstruction.images[i].name;
  }
  const std::string message = RefusalOf(reconstruction, positions);
  EXPECT_THAT(message, HasSubstr("21 positions is bad"));
  EXPECT_THAT(message, HasSubstr("median residual"));
}

// Errors of 15 m spread the positions of photos that were taken within 12 m.
TEST(Georegister, RefusesAScaleThatTheErrorsOfPositionsMake) {
  const Reconstruction reconstruction =
      testing::StreetWorld({.length_m = 12.0, .keyframe_step_m = 1.0}).Reconstruct();
  GeoregisterOptions options;
  options.up = UpSource::kTop;
  std::vector<CameraPosition> positions = NoisyPositions(reconstruction, 15.0);
  for (CameraPosition& position : positions) {
    position.has_height = false;
  }
  for (const double stated_m : {5.0, 10.0, 15.0}) {
    for (CameraPosition& position : positions) {
      position.accuracy_m = stated_m;
    }
    EXPECT_THAT(RefusalOf(reconstruction, positions, options), HasSubstr("scale")) << stated_m;
  }
}

// Photos of strangers: positions that are off by tens of meters and say so.
TEST(Georegister, TakesPositionsAsRoughAsTheyState) {
  const Reconstruction reconstruction =
      testing::StreetWorld({.length_m = 600.0, .keyframe_step_m = 10.0, .num_landmarks = 300})
          .Reconstruct();
  GeoregisterOptions options;
  options.up = UpSource::kTop;
  std::vector<CameraPosition> positions = NoisyPositions(reconstruction, 30.0);
  EXPECT_EQ(RefusalOf(reconstruction, positions, options), "no error");
  for (CameraPosition& position : positions) {
    position.accuracy_m = 10.0;
  }
  EXPECT_THAT(RefusalOf(reconstruction, positions, options), HasSubstr("--gps-accuracy"));
}

TEST(Georegister, ARefusalNamesNoLimitThatIsNotFinite) {
  const Reconstruction reconstruction = testing::StreetWorld().Reconstruct();
  GeoregisterOptions options;
  options.max_median_residual_sigmas = std::numeric_limits<double>::infinity();
  options.max_median_residual_m = 0.01;
  std::vector<CameraPosition> positions = NoisyPositions(reconstruction, 0.1);
  for (CameraPosition& position : positions) {
    position.accuracy_m = 0.001;
  }
  EXPECT_THAT(RefusalOf(reconstruction, positions, options),
              HasSubstr("; the limit is 0.01 m), largest"));
}

TEST(Georegister, RefusesNumbersThatAreNotFinite) {
  const Reconstruction reconstruction = testing::StreetWorld().Reconstruct();
  std::vector<CameraPosition> positions = GpsPositions(reconstruction, 1.0);
  positions[3].position.lat_rad = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(RefusalOf(reconstruction, positions), "no error");
}

TEST(MakeHeightsEllipsoidal, AddsTheGeoidToHeightsAboveMeanSeaLevel) {
  const Geodetic lund = Geodetic::FromDegrees(55.705, 13.19, 50.0);
  const Geodetic philadelphia = Geodetic::FromDegrees(39.95, -75.16, 50.0);
  std::vector<CameraPosition> positions = {{"a", lund}, {"b", philadelphia}};
  MakeHeightsEllipsoidal({}, HeightReference::kEllipsoid, &positions);
  EXPECT_EQ(positions[0].position.h_m, 50.0);
  positions[0].height_reference = HeightReference::kMeanSeaLevel;
  positions[1].height_reference.reset();
  MakeHeightsEllipsoidal({}, HeightReference::kMeanSeaLevel, &positions);
  EXPECT_NEAR(positions[0].position.h_m, 50.0 + 35.7, 0.1);
  EXPECT_NEAR(positions[1].position.h_m, 50.0 - 34.2, 0.1);
}

TEST(MakeHeightsEllipsoidal, WhatIsChosenCountsBeforeWhatIsStated) {
  std::vector<CameraPosition> positions = {{"a", Geodetic::FromDegrees(55.705, 13.19, 50.0)}};
  positions[0].height_reference = HeightReference::kMeanSeaLevel;
  MakeHeightsEllipsoidal(HeightReference::kEllipsoid, HeightReference::kMeanSeaLevel, &positions);
  EXPECT_EQ(positions[0].position.h_m, 50.0);
}

class CameraPositionsCsv : public ::testing::Test {
 protected:
  std::vector<CameraPosition> Read(const std::string& text) {
    std::ofstream(dir_.File("positions.csv")) << text;
    return ReadCameraPositions(dir_.File("positions.csv"));
  }
  std::string RefusalOf(const std::string& text) {
    try {
      Read(text);
    } catch (const Error& e) {
      return e.what();
    }
    return "no error";
  }
  testing::TempDir dir_;
};

TEST_F(CameraPositionsCsv, AByteOrderMarkIsNoPartOfTheHeader) {
  EXPECT_EQ(Read("\xef\xbb\xbfimage,lat_deg,lon_deg,h_m\r\na.jpg,47,8,400\r\n").size(), 1u);
}

TEST_F(CameraPositionsCsv, CellsOfMegabytesAreNotEchoed) {
  EXPECT_LT(RefusalOf("image,lat_deg,lon_deg,h_m\na.jpg," + std::string(2'000'000, 'x') + ",8,1\n")
                .size(),
            500u);
}

TEST_F(CameraPositionsCsv, AFileWithoutEndIsRefused) {
  EXPECT_THROW(ReadCameraPositions("/dev/zero"), Error);
}

TEST_F(CameraPositionsCsv, ReadsColumnsInAnyOrder) {
  const auto positions =
      Read("h_m, lon_deg,image,lat_deg\n400.5,8.5,a.jpg,47.25\n\n401,8.6,b.jpg,-47\n");
  ASSERT_EQ(positions.size(), 2u);
  EXPECT_EQ(positions[0].image_name, "a.jpg");
  EXPECT_DOUBLE_EQ(positions[0].position.lat_deg(), 47.25);
  EXPECT_DOUBLE_EQ(positions[0].position.h_m, 400.5);
  EXPECT_DOUBLE_EQ(positions[0].accuracy_m, 5.0);
  EXPECT_DOUBLE_EQ(positions[1].position.lat_deg(), -47.0);
}

TEST_F(CameraPositionsCsv, QuotesOfSpreadsheetsAndScriptsAreRead) {
  const auto positions = Read(
      "\"image\",\"lat_deg\",\"lon_deg\",\"h_m\"\r\n\"Lund, street 1.jpg\",\"47.5\",8,+400\r\n");
  ASSERT_EQ(positions.size(), 1u);
  EXPECT_EQ(positions[0].image_name, "Lund, street 1.jpg");
  EXPECT_DOUBLE_EQ(positions[0].position.lat_deg(), 47.5);
  EXPECT_DOUBLE_EQ(Read("image;lat_deg;lon_deg;h_m\na;47,5;8,25;400\n")[0].position.lon_deg(),
                   8.25);
}

TEST_F(CameraPositionsCsv, ATableWithoutPositionsIsRefused) {
  EXPECT_THAT(RefusalOf("image,lat_deg,lon_deg,h_m\n\n"), HasSubstr("no position"));
}

TEST_F(CameraPositionsCsv, NamesOfConvertedPhotosAreFoundAndNoted) {
  std::ofstream(dir_.File("positions.csv"))
      << "image,lat_deg,lon_deg,h_m\n01.HEIC,47,8,400\n02.HEIC,47.1,8,401\n";
  std::vector<std::string> notes;
  const auto positions =
      ReadPositionsOfPhotos(dir_.File("positions.csv"), {"02.jpg", "01.jpg"}, &notes);
  ASSERT_EQ(positions.size(), 2u);
  EXPECT_EQ(positions[1].image_name, "02.jpg");
  EXPECT_NEAR(positions[1].position.lat_deg(), 47.1, 1e-9);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_THAT(notes[0], HasSubstr("2 positions have names that the photos write in another way"));
  EXPECT_THAT(notes[0], HasSubstr("'02.HEIC' as '02.jpg'"));
}

TEST(NameAfterImages, FindsNamesThatAreWrittenInAnotherWay) {
  Reconstruction reconstruction = testing::StreetWorld().Reconstruct();
  reconstruction.images[0].name = "cam/u\u0308ber 0.JPG";
  std::vector<CameraPosition> positions = GpsPositions(reconstruction, 1.0);
  positions[0].image_name = "cam/\u00fcber 0.jpg";
  positions.push_back({"elsewhere.jpg", positions[0].position, 1.0});
  NameAfterImages(reconstruction, &positions);
  EXPECT_EQ(positions[0].image_name, reconstruction.images[0].name);
  EXPECT_EQ(positions[1].image_name, reconstruction.images[1].name);
  EXPECT_EQ(positions.back().image_name, "elsewhere.jpg");
}

TEST(NameAfterImages, RefusesNamesOfOtherImagesWithExamplesOfBoth) {
  const Reconstruction reconstruction = testing::StreetWorld().Reconstruct();
  std::vector<CameraPosition> positions = {{"IMG_1.heic", {}, 1.0}, {"IMG_2.heic", {}, 1.0}};
  try {
    NameAfterImages(reconstruction, &positions);
    FAIL();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("'IMG_1.heic', 'IMG_2.heic'"));
    EXPECT_THAT(e.what(), HasSubstr("'" + reconstruction.images[0].name + "'"));
  }
}

TEST_F(CameraPositionsCsv, ReadsTheAccuracy) {
  EXPECT_DOUBLE_EQ(Read("image,lat_deg,lon_deg,h_m,accuracy_m\na,1,2,3,0.05\n")[0].accuracy_m,
                   0.05);
}

TEST_F(CameraPositionsCsv, ErrorsNameLineAndColumn) {
  const std::string header = "image,lat_deg,lon_deg,h_m,accuracy_m\n";
  EXPECT_THAT(RefusalOf(header + "a,1,2,3,1\nb,1,x2,3,1\n"), HasSubstr("line 3: column lon_deg"));
  EXPECT_THAT(RefusalOf(header + "a,1,nan,3,1\n"), HasSubstr("line 2: column lon_deg"));
  EXPECT_THAT(RefusalOf(header + "a,91,2,3,1\n"), HasSubstr("line 2"));
  EXPECT_THAT(RefusalOf(header + "a,1,2,3,0\n"), HasSubstr("accuracy_m"));
  EXPECT_THAT(RefusalOf(header + "a,1,2\n"), HasSubstr("line 2: 3 columns"));
  EXPECT_THAT(RefusalOf("image,lat_deg,lon_deg\n"), HasSubstr("h_m"));
  EXPECT_THAT(RefusalOf(""), HasSubstr("header"));
}

}  // namespace
}  // namespace cairn
