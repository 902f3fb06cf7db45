#include "core/features.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/angles.h"
#include "core/error.h"
#include "core/keypoint_shape.h"
#include "core/rigid3.h"

namespace cairn {
namespace {

FeatureSet TwoFeatures() {
  FeatureSet features;
  features.keypoints = {{1.0f, 2.0f, 1.5f, 0.0f}, {3.0f, 4.0f, 2.0f, 1.0f}};
  features.descriptors = DescriptorMatrix::Ones(2, 128);
  return features;
}

TEST(Features, AcceptsWhatIsConsistent) { EXPECT_NO_THROW(ValidateFeatures(TwoFeatures(), "q")); }

TEST(Features, RefusesWhatIsNot) {
  FeatureSet fewer = TwoFeatures();
  fewer.keypoints.pop_back();
  EXPECT_THROW(ValidateFeatures(fewer, "q"), Error);
  FeatureSet not_finite = TwoFeatures();
  not_finite.descriptors(1, 5) = std::numeric_limits<float>::infinity();
  EXPECT_THROW(ValidateFeatures(not_finite, "q"), Error);
  FeatureSet negative = TwoFeatures();
  negative.keypoints[0].scale_px = -1.0f;
  EXPECT_THROW(ValidateFeatures(negative, "q"), Error);
  FeatureSet endless = TwoFeatures();
  endless.keypoints[0].orientation_rad = std::numeric_limits<float>::infinity();
  EXPECT_THROW(ValidateFeatures(endless, "q"), Error);
}

TEST(Features, MayHaveNeitherSizeNorOrientation) {
  FeatureSet points = TwoFeatures();
  points.keypoints[1] = KeypointWithoutShape(3.0f, 4.0f);
  EXPECT_NO_THROW(ValidateFeatures(points, "q"));
  EXPECT_TRUE(HasScale(points.keypoints[0]) && HasOrientation(points.keypoints[0]));
  EXPECT_FALSE(HasScale(points.keypoints[1]) || HasOrientation(points.keypoints[1]));
}

TEST(GravityRectifiedOrientation, OfAKeypointWithoutOrientationIsUnknown) {
  EXPECT_FALSE(GravityRectifiedOrientationRad(Camera(), KeypointWithoutShape(320.0f, 240.0f),
                                              {0.0, 1.0, 0.0}));
}

TEST(GravityRectifiedOrientation, IsZeroForAKeypointThatPointsDown) {
  const Camera camera;
  const Keypoint keypoint{320.0f, 240.0f, 1.0f, static_cast<float>(0.5 * kPi)};
  const auto angle = GravityRectifiedOrientationRad(camera, keypoint, {0.0, 1.0, 0.0});
  ASSERT_TRUE(angle);
  EXPECT_NEAR(*angle, 0.0, 1e-6);
}

TEST(GravityRectifiedOrientation, DoesNotChangeWhenTheCameraRolls) {
  const Camera camera;
  constexpr double kRollRad = 0.7;
  // Rolling the camera about its axis turns image content and gravity alike.
  const Keypoint upright{320.0f, 240.0f, 1.0f, 0.3f};
  const Keypoint rolled{320.0f, 240.0f, 1.0f, static_cast<float>(0.3 + kRollRad)};
  const Eigen::Vector3d down(0.0, 1.0, 0.0);
  const Eigen::Vector3d rolled_down = ExpSo3({0.0, 0.0, kRollRad}) * down;
  EXPECT_NEAR(*GravityRectifiedOrientationRad(camera, upright, down),
              *GravityRectifiedOrientationRad(camera, rolled, rolled_down), 1e-6);
}

TEST(GravityRectifiedOrientation, IsMeaninglessLookingStraightDown) {
  const Camera camera;
  const Keypoint keypoint{320.0f, 240.0f, 1.0f, 0.0f};
  EXPECT_FALSE(GravityRectifiedOrientationRad(camera, keypoint, {0.0, 0.0, 1.0}));
}

TEST(WrapAngle, StaysInTheHalfOpenInterval) {
  EXPECT_NEAR(WrapAngleRad(3.0 * kPi), kPi, 1e-12);
  EXPECT_NEAR(WrapAngleRad(-kPi), kPi, 1e-12);
  EXPECT_NEAR(WrapAngleRad(7.0), 7.0 - 2.0 * kPi, 1e-12);
}

}  // namespace
}  // namespace cairn
