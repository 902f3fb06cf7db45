#include "core/scene/reconstruction.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/error.h"
#include "support/reconstruction_builder.h"

namespace cairn {
namespace {

TEST(Reconstruction, AcceptsTheSyntheticStreet) {
  const testing::StreetWorld world;
  const Reconstruction reconstruction = world.Reconstruct();
  EXPECT_NO_THROW(reconstruction.Validate());
  EXPECT_EQ(reconstruction.images.size(), 21u);
  EXPECT_GT(reconstruction.landmarks.size(), 800u);
  EXPECT_EQ(reconstruction.descriptor_dim(), 128);
}

TEST(Reconstruction, ObservationsReprojectWithinTheNoise) {
  const testing::StreetWorld world;
  const Reconstruction reconstruction = world.Reconstruct();
  for (const ReconLandmark& landmark : reconstruction.landmarks) {
    for (const ReconObservation& observation : landmark.observations) {
      const ReconImage& image = reconstruction.images[observation.image_idx];
      const Keypoint& keypoint = image.features.keypoints[observation.keypoint_idx];
      const auto pixel = world.camera().Project(image.cam_from_world * landmark.x_in_world);
      ASSERT_TRUE(pixel.has_value());
      EXPECT_NEAR(pixel->x(), keypoint.x_px, 6 * world.options().pixel_noise_px);
      EXPECT_NEAR(pixel->y(), keypoint.y_px, 6 * world.options().pixel_noise_px);
    }
  }
}

TEST(Reconstruction, RefusesIndicesOutOfRange) {
  const Reconstruction good = testing::StreetWorld().Reconstruct();
  Reconstruction bad = good;
  bad.landmarks[0].observations[0].image_idx = static_cast<int>(bad.images.size());
  EXPECT_THROW(bad.Validate(), Error);
  bad = good;
  bad.landmarks[0].observations[0].keypoint_idx = -1;
  EXPECT_THROW(bad.Validate(), Error);
  bad = good;
  bad.images[3].camera_idx = 1;
  EXPECT_THROW(bad.Validate(), Error);
}

TEST(Reconstruction, RefusesTwoObservationsInOneImage) {
  Reconstruction bad = testing::StreetWorld().Reconstruct();
  ReconObservation twin = bad.landmarks[5].observations[0];
  twin.keypoint_idx = twin.keypoint_idx == 0 ? 1 : 0;
  bad.landmarks[5].observations.push_back(twin);
  EXPECT_THROW(bad.Validate(), Error);
}

TEST(Reconstruction, RefusesNumbersThatAreNotFinite) {
  const Reconstruction good = testing::StreetWorld().Reconstruct();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Reconstruction bad = good;
  bad.landmarks[2].x_in_world.y() = nan;
  EXPECT_THROW(bad.Validate(), Error);
  bad = good;
  bad.images[1].cam_from_world.translation.x() = nan;
  EXPECT_THROW(bad.Validate(), Error);
  bad = good;
  DescriptorMatrix descriptors = bad.images[1].features.descriptors.Unpacked();
  descriptors(0, 0) = static_cast<float>(nan);
  bad.images[1].features.descriptors = descriptors;
  EXPECT_THROW(bad.Validate(), Error);
}

TEST(Reconstruction, RefusesMixedDescriptorDimensions) {
  Reconstruction bad = testing::StreetWorld().Reconstruct();
  PackedFeatures& features = bad.images[4].features;
  features.descriptors = DescriptorMatrix(DescriptorMatrix::Zero(features.size(), 64));
  EXPECT_THROW(bad.Validate(), Error);
}

}  // namespace
}  // namespace cairn
