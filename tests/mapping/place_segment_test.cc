#include "mapping/session/place_segment.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/error.h"
#include "mapping/street_segment.h"

namespace cairn {
namespace {

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
  const PlacedSegment placed = PlaceSegment(street.set, street.places, street.segment, {}, {});
  EXPECT_LT(LargestError(street, placed), 0.2);
  EXPECT_NEAR(placed.georegistration.ecef_from_world.scale, 1.0, 1e-12);
  EXPECT_LT(placed.adjustment.rms_px, 1.0);
}

TEST(PlaceSegment, DoesNotBendAStreetToPoorPositions) {
  testing::StreetSegment street = testing::MakeStreetSegment(2.0);
  street.places.positions[5].reset();
  street.places.positions[7]->position.lat_rad += 1e-5;  // 64 m.
  const PlacedSegment placed = PlaceSegment(street.set, street.places, street.segment, {}, {});
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

TEST(PlaceSegment, KeepsAFocalLengthOfExifThatTheGrowthHeld) {
  testing::StreetSegment street = testing::MakeStreetSegment(0.05);
  MappingCamera& known = street.set.cameras[0];
  known.source = FocalSource::kExif;
  known.focal.log_sigma = 0.05;
  const PlacedSegment placed = PlaceSegment(street.set, street.places, street.segment, {}, {});
  EXPECT_EQ(placed.segment.model.cameras[0].params(), known.camera.params());
}

TEST(PlaceSegment, SaysHowManyPositionsItNeeds) {
  testing::StreetSegment street = testing::MakeStreetSegment(0.05);
  for (size_t i = 2; i < street.places.positions.size(); ++i) {
    street.places.positions[i].reset();
  }
  try {
    PlaceSegment(street.set, street.places, street.segment, {}, {});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadInput);
    EXPECT_NE(std::string(error.what()).find("2 of its 16 photos"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace cairn
