#include "cli/demo/street/reconstruct_known_poses.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cli/demo/street/street_scene.h"
#include "core/error.h"
#include "core/statistics.h"

namespace cairn {
namespace {

// Photos of a short street and what is reconstructed from them; made once for all tests.
struct StreetModel {
  StreetScene scene;
  std::vector<StreetPhoto> photos;
  Reconstruction reconstruction;

  StreetModel()
      : scene({.length_m = 40.0,
               .mapping_step_m = 5.0,
               .image_width_px = 480,
               .image_height_px = 360,
               .focal_px = 315.0}),
        photos(scene.TakePhotos(scene.MappingPoses(), "map_")),
        reconstruction(ReconstructWithKnownPoses(scene.camera(), photos)) {}
};

const StreetModel& Model() {
  static const StreetModel* model = new StreetModel;
  return *model;
}

TEST(ReconstructWithKnownPoses, LandmarksLieOnTheTrueSurfaces) {
  std::vector<double> errors_m;
  for (const ReconLandmark& landmark : Model().reconstruction.landmarks) {
    errors_m.push_back(Model().scene.DistanceToSurfaceM(landmark.x_in_world));
  }
  ASSERT_GT(errors_m.size(), 1500u);
  EXPECT_LT(ValueAtShare(errors_m, 0.5), 0.03);
  EXPECT_LT(ValueAtShare(errors_m, 0.9), 0.25);
}

TEST(ReconstructWithKnownPoses, ObservationsFitWithinTheBound) {
  const Reconstruction& reconstruction = Model().reconstruction;
  std::vector<double> x_errors_px, y_errors_px;
  for (const ReconLandmark& landmark : reconstruction.landmarks) {
    EXPECT_GE(static_cast<int>(landmark.observations.size()), kMinKnownPoseObservations);
    for (const ReconObservation& observation : landmark.observations) {
      const ReconImage& image = reconstruction.images[observation.image_idx];
      const Keypoint& keypoint = image.features.keypoints[observation.keypoint_idx];
      const auto pixel =
          reconstruction.cameras[0].Project(image.cam_from_world * landmark.x_in_world);
      ASSERT_TRUE(pixel.has_value());
      const Eigen::Vector2d error = *pixel - Eigen::Vector2d(keypoint.x_px, keypoint.y_px);
      EXPECT_LE(error.norm(), kMaxKnownPoseErrorPx);
      x_errors_px.push_back(error.x());
      y_errors_px.push_back(error.y());
    }
  }
  EXPECT_NEAR(ValueAtShare(x_errors_px, 0.5), 0.0, 0.05);
  EXPECT_NEAR(ValueAtShare(y_errors_px, 0.5), 0.0, 0.05);
}

TEST(ReconstructWithKnownPoses, IsAValidReconstruction) {
  const Reconstruction& reconstruction = Model().reconstruction;
  EXPECT_NO_THROW(reconstruction.Validate());
  ASSERT_EQ(reconstruction.images.size(), Model().photos.size());
  EXPECT_EQ(reconstruction.images[3].name, "map_003.png");
  EXPECT_TRUE(reconstruction.images[3].gps.has_value());
}

TEST(ReconstructWithKnownPoses, DoesNotDependOnThreads) {
  const std::vector<StreetPhoto> few(Model().photos.begin(), Model().photos.begin() + 9);
  KnownPoseOptions options;
  options.sift.max_features = 400;
  options.num_threads = 1;
  const Reconstruction one = ReconstructWithKnownPoses(Model().scene.camera(), few, options);
  options.num_threads = 3;
  const Reconstruction three = ReconstructWithKnownPoses(Model().scene.camera(), few, options);
  ASSERT_EQ(one.landmarks.size(), three.landmarks.size());
  EXPECT_GT(one.landmarks.size(), 10u);
  for (size_t i = 0; i < one.landmarks.size(); ++i) {
    EXPECT_EQ(one.landmarks[i].x_in_world, three.landmarks[i].x_in_world);
  }
}

TEST(ReconstructWithKnownPoses, OfNothingIsEmpty) {
  const Reconstruction reconstruction = ReconstructWithKnownPoses(Model().scene.camera(), {});
  EXPECT_TRUE(reconstruction.images.empty());
  EXPECT_TRUE(reconstruction.landmarks.empty());
}

TEST(KnownPoseOptions, RefusesNonsense) {
  KnownPoseOptions options;
  options.num_threads = 0;
  EXPECT_THROW(options.Validate(), Error);
  options = {};
  options.sift.max_features = 0;
  EXPECT_THROW(options.Validate(), Error);
}

}  // namespace
}  // namespace cairn
