#include "mapping/session/place_segment.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/error.h"
#include "mapping/street_segment.h"

namespace cairn {
namespace {

PlacedSegment Place(const testing::StreetSegment& street) {
  return PlaceSegment(street.places,
                      AdjustToPositions(street.set, street.places, street.segment, {}, {}), {});
}

double LargestError(const testing::StreetSegment& street, const PlacedSegment& placed) {
  double largest_m = 0.0;
  for (const ReconImage& image : placed.segment.model.images) {
    const Eigen::Vector3d found_in_ecef =
        placed.georegistration.ecef_from_world * image.cam_from_world.Inverse().translation;
    largest_m = std::max(largest_m, (found_in_ecef - EcefFromGeodetic(*image.gps)).norm());
  }
  return largest_m;
}

TEST(PlaceSegment, PutsPhotosWhereTheirPositionsAre) {
  const testing::StreetSegment street = testing::MakeStreetSegment(0.05);
  const PlacedSegment placed = Place(street);
  EXPECT_LT(LargestError(street, placed), 0.2);
  EXPECT_NEAR(placed.georegistration.ecef_from_world.scale, 1.0, 1e-12);
  EXPECT_LT(placed.adjustment.rms_px, 1.0);
}

TEST(PlaceSegment, ReportsTheIterationsOfTheAdjustment) {
  const testing::StreetSegment street = testing::MakeStreetSegment(2.0);
  int most_done = 0;
  AdjustToPositions(street.set, street.places, street.segment, {}, {}, [&](int done, int most) {
    EXPECT_LE(done, most);
    most_done = std::max(most_done, done);
  });
  EXPECT_GT(most_done, 0);
}

TEST(PlaceSegment, DoesNotBendAStreetToPoorPositions) {
  testing::StreetSegment street = testing::MakeStreetSegment(2.0);
  street.places.positions[5].reset();
  street.places.positions[7]->position.lat_rad += 1e-5;  // 64 m.
  const PlacedSegment placed = Place(street);
  const Reconstruction& model = placed.segment.model;
  const Reconstruction& truth = street.segment.model;
  Eigen::Matrix3Xd found(3, model.images.size()), expected(3, model.images.size());
  for (size_t i = 0; i < model.images.size(); ++i) {
    found.col(i) = model.images[i].cam_from_world.Inverse().translation;
    expected.col(i) = street.world.options().world_from_enu.Inverse() *
                      truth.images[i].cam_from_world.Inverse().translation;
  }
  const Eigen::Matrix4d fit = Eigen::umeyama(found, expected, /*with_scaling=*/true);
  const Eigen::Matrix3Xd error =
      ((fit.topLeftCorner<3, 3>() * found).colwise() + fit.topRightCorner<3, 1>()) - expected;
  EXPECT_LT(error.colwise().norm().maxCoeff(), 0.1);
}

// The Earth's positions are better than what a growing segment keeps of its shape.
TEST(PlaceSegment, StraightensABentStreetByGoodPositions) {
  testing::StreetSegment street = testing::MakeStreetSegment(0.03);
  const Sim3d enu_from_world = street.world.options().world_from_enu.Inverse();
  const auto bend = [&](const Eigen::Vector3d& x_in_world) {
    Eigen::Vector3d x_in_enu = enu_from_world * x_in_world;
    x_in_enu.y() += 6e-4 * x_in_enu.x() * x_in_enu.x();  // 1.2 m at the end.
    return Eigen::Vector3d(street.world.options().world_from_enu * x_in_enu);
  };
  for (ReconImage& image : street.segment.model.images) {
    const Eigen::Vector3d center = bend(image.cam_from_world.Inverse().translation);
    image.cam_from_world.translation = -(image.cam_from_world.rotation * center);
  }
  for (ReconLandmark& landmark : street.segment.model.landmarks) {
    landmark.x_in_world = bend(landmark.x_in_world);
  }
  const PlacedSegment placed = Place(street);
  EXPECT_LT(LargestError(street, placed), 0.15);
  EXPECT_LT(placed.adjustment.rms_px, 1.0);
}

// Positions of other photos: no bending makes the street fit them.
TEST(PlaceSegment, RefusesPositionsThatTheStreetDoesNotFit) {
  testing::StreetSegment street = testing::MakeStreetSegment(0.03);
  auto& positions = street.places.positions;
  for (size_t i = 0; i + 1 < positions.size(); i += 2) {
    std::swap(positions[i]->position, positions[i + 1]->position);  // 3 m off, each.
  }
  EXPECT_THROW(Place(street), Error);
}

TEST(PlaceSegment, KeepsAFocalLengthOfExifThatTheGrowthHeld) {
  testing::StreetSegment street = testing::MakeStreetSegment(0.05);
  MappingCamera& known = street.set.cameras[0];
  known.source = FocalSource::kExif;
  known.focal.log_sigma = 0.05;
  const PlacedSegment placed = Place(street);
  EXPECT_EQ(placed.segment.model.cameras[0].params(), known.camera.params());
}

TEST(PlaceSegment, SaysHowManyPositionsItNeeds) {
  testing::StreetSegment street = testing::MakeStreetSegment(0.05);
  for (size_t i = 2; i < street.places.positions.size(); ++i) {
    street.places.positions[i].reset();
  }
  try {
    Place(street);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadInput);
    EXPECT_NE(std::string(error.what()).find("2 of its 16 photos"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace cairn
