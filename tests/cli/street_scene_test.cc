#include "cli/demo/street/street_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/error.h"

namespace cairn {
namespace {

StreetOptions SmallStreet() {
  StreetOptions options;
  options.length_m = 40.0;
  options.num_queries = 4;
  return options;
}

// Painted once for all tests.
const StreetScene& Scene() {
  static const StreetScene* scene = new StreetScene(SmallStreet());
  return *scene;
}

TEST(StreetScene, IsDeterministic) {
  const Rigid3d pose = Scene().MappingPoses()[1];
  const StreetScene again(SmallStreet());
  EXPECT_EQ(Scene().Render(pose, 7).pixels, again.Render(pose, 7).pixels);
  EXPECT_NE(Scene().Render(pose, 7).pixels, Scene().Render(pose, 8).pixels);
}

TEST(StreetScene, DependsOnTheSeed) {
  StreetOptions options = SmallStreet();
  options.seed = 2;
  const Rigid3d pose = Scene().MappingPoses()[1];
  EXPECT_NE(Scene().Render(pose, 7).pixels, StreetScene(options).Render(pose, 7).pixels);
}

TEST(StreetScene, PhotosDoNotDependOnThreads) {
  const std::vector<Rigid3d> poses = Scene().QueryPoses();
  const auto one = Scene().TakePhotos(poses, "query_", 1),
             two = Scene().TakePhotos(poses, "query_", 2);
  ASSERT_EQ(one.size(), 4u);
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].image.pixels, two[i].image.pixels);
    EXPECT_EQ(one[i].gps->lat_rad, two[i].gps->lat_rad);
  }
  EXPECT_EQ(one[3].name, "query_003.png");
}

TEST(StreetScene, PhotosHaveFeaturesLikeRealOnes) {
  for (const StreetPhoto& photo : Scene().TakePhotos(Scene().QueryPoses(), "query_")) {
    const int num_features = ExtractSift(photo.image).size();
    EXPECT_GE(num_features, 800);
    EXPECT_LE(num_features, 2000);
  }
}

TEST(StreetScene, GpsIsNoisyButNear) {
  const std::vector<Rigid3d> poses = Scene().MappingPoses();
  const Rigid3d enu_from_ecef = EcefFromEnu(Scene().options().origin).Inverse();
  double sum_of_squares = 0.0;
  const std::vector<StreetPhoto> photos = Scene().TakePhotos(poses, "map_");
  for (const StreetPhoto& photo : photos) {
    const Eigen::Vector3d error =
        enu_from_ecef * EcefFromGeodetic(*photo.gps) - photo.cam_from_enu.Inverse().translation;
    sum_of_squares += error.squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(sum_of_squares / (3.0 * photos.size())), Scene().options().gps_sigma_m,
              0.8);
}

TEST(StreetScene, CamerasStandInTheStreetAndSeeIt) {
  std::vector<Rigid3d> poses = Scene().MappingPoses();
  for (const Rigid3d& pose : Scene().QueryPoses()) {
    poses.push_back(pose);
  }
  for (const Rigid3d& cam_from_enu : poses) {
    const Eigen::Vector3d center = cam_from_enu.Inverse().translation;
    EXPECT_GT(center.z(), 1.3);
    EXPECT_LT(center.z(), 2.5);
    EXPECT_LT(center.head<2>().norm(), 0.5 * std::hypot(40.0, 16.0));
    EXPECT_GT(Scene().DistanceToSurfaceM(center), 0.2);
  }
}

TEST(StreetOptions, RefusesNonsense) {
  EXPECT_THROW(StreetScene({.length_m = 5.0}), Error);
  EXPECT_THROW(StreetScene({.mapping_step_m = 0.0}), Error);
  EXPECT_THROW(StreetScene({.num_queries = 0}), Error);
  EXPECT_THROW(StreetScene({.focal_px = NAN}), Error);
  EXPECT_THROW(StreetScene({.image_width_px = 1 << 30}), Error);
}

}  // namespace
}  // namespace cairn
