// Growth from photos of strangers: a camera each, far apart, of which nobody knows anything.
#include <gtest/gtest.h>

#include "mapping/facade_views.h"
#include "mapping/growth/grow_segments.h"

namespace cairn {
namespace {

// Five photos from the front and four from the side.
const std::vector<testing::FacadePhoto> kTwoSides = {
    {-6.0, 0.0, 1.0}, {-3.0, 3.0, 0.8}, {0.0, -4.0, 1.3}, {2.0, 1.0, 1.0},  {4.0, -2.0, 0.9},
    {24.0, 6.0, 1.0}, {26.0, 8.0, 0.9}, {25.0, 3.0, 1.2}, {29.0, 10.0, 1.0}};
constexpr int kFirstOfSide = 5;

bool IsOneSide(int a, int b) { return (a < kFirstOfSide) == (b < kFirstOfSide); }

// Focal lengths as CalibrateGuesses finds them: some percent off.
PhotoSet Calibrated(const testing::FacadeViews& world,
                    const std::vector<testing::FacadePhoto>& photos) {
  PhotoSet set = world.set;
  for (size_t i = 0; i < set.cameras.size(); ++i) {
    MappingCamera& camera = set.cameras[i];
    const double error = 0.04 * (static_cast<double>(i % 3) - 1.0);
    camera.camera = WithFocalScaled(camera.camera, photos[i].focal_factor * (1.0 + error));
    camera.focal.log_sigma = 0.05;
    camera.source = FocalSource::kPhotos;
  }
  return set;
}

// The two sides share a twelfth of what the photos of a side share: the directions from which they
// were taken explain that.
TEST(GrowStrangers, WeakLinksBetweenTwoSidesOfABuildingJoinThem) {
  const testing::FacadeViews world = testing::MakeFacadeViews(
      kTwoSides, [](int a, int b, int point) { return IsOneSide(a, b) || point % 12 == 0; });
  const PhotoSet set = Calibrated(world, kTwoSides);
  const Growth growth = GrowSegments(set, world.views, GrowthOptions());
  ASSERT_EQ(growth.segments.size(), 1u);
  const Segment& segment = growth.segments[0];
  ASSERT_EQ(segment.photo_of_image.size(), kTwoSides.size());
  Eigen::Matrix3Xd found(3, kTwoSides.size()), truth(3, kTwoSides.size());
  for (size_t i = 0; i < kTwoSides.size(); ++i) {
    found.col(i) = segment.model.images[i].cam_from_world.Inverse().translation;
    truth.col(i) = world.cam_from_world[i].Inverse().translation;
  }
  const Eigen::Matrix4d fit = Eigen::umeyama(found, truth, true);
  for (size_t i = 0; i < kTwoSides.size(); ++i) {
    EXPECT_LT(((fit * found.col(i).homogeneous()).head<3>() - truth.col(i)).norm(), 0.25) << i;
  }
}

// Links that are as weak between photos from the same places are those to a copy of the facade.
TEST(GrowStrangers, WeakLinksFromTheSamePlaceJoinNothing) {
  std::vector<testing::FacadePhoto> photos = kTwoSides;
  for (int i = kFirstOfSide; i < static_cast<int>(photos.size()); ++i) {
    photos[i] = photos[i - kFirstOfSide];
    photos[i].x_m += 0.7;
  }
  const testing::FacadeViews world = testing::MakeFacadeViews(
      photos, [](int a, int b, int point) { return IsOneSide(a, b) || point % 12 == 0; });
  const Growth growth = GrowSegments(Calibrated(world, photos), world.views, GrowthOptions());
  ASSERT_EQ(growth.segments.size(), 2u);
  EXPECT_EQ(growth.segments[0].photo_of_image.size(), 5u);
  EXPECT_EQ(growth.segments[1].photo_of_image.size(), 4u);
}

}  // namespace
}  // namespace cairn
