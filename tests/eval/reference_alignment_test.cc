#include "eval/reference_alignment.h"

#include <gtest/gtest.h>

#include <string>

#include "core/geodesy.h"

namespace cairn {
namespace {

// A model of cameras along a straight line, as a drive has them, and the similarity that places it.
class ReferenceAlignmentTest : public ::testing::Test {
 protected:
  ReferenceAlignmentTest() {
    for (int i = 0; i < 10; ++i) {
      ReconImage image;
      image.name = std::to_string(i);
      const Eigen::Quaterniond cam_from_world = ExpSo3(Eigen::Vector3d(0.1 * i, 0.02, -0.03 * i));
      image.cam_from_world = {cam_from_world, cam_from_world * Eigen::Vector3d(-0.5 * i, 0.0, 0.0)};
      reconstruction_.images.push_back(image);
    }
    const Rigid3d ecef_from_enu = EcefFromEnu(Geodetic::FromDegrees(47.4, 8.5, 400.0));
    ecef_from_world_ = ecef_from_enu * Sim3d{3.7, ExpSo3(Eigen::Vector3d(0.4, -1.0, 2.0)),
                                             Eigen::Vector3d(10.0, 20.0, 30.0)};
  }

  KeyframeRecord Keyframe(int image_idx) const {
    KeyframeRecord keyframe;
    keyframe.image_name = reconstruction_.images[image_idx].name;
    keyframe.cam_from_ecef =
        CamFromTarget(reconstruction_.images[image_idx].cam_from_world, ecef_from_world_);
    return keyframe;
  }

  Reconstruction reconstruction_;
  Sim3d ecef_from_world_;
};

TEST_F(ReferenceAlignmentTest, RecoversThePlacementFromCamerasOnALine) {
  const auto alignment =
      AlignToKeyframes(reconstruction_, {Keyframe(1), Keyframe(3), Keyframe(4), Keyframe(8)});
  ASSERT_TRUE(alignment);
  EXPECT_EQ(alignment->num_shared_images, 4);
  EXPECT_NEAR(alignment->ecef_from_world.scale, ecef_from_world_.scale, 1e-8);
  EXPECT_LT(RotationAngleRad(alignment->ecef_from_world.rotation, ecef_from_world_.rotation), 1e-8);
  const Eigen::Vector3d off_the_line(5.0, 7.0, -2.0);
  EXPECT_LT((alignment->ecef_from_world * off_the_line - ecef_from_world_ * off_the_line).norm(),
            1e-6);
  EXPECT_LT(alignment->max_residual_m, 1e-6);
  EXPECT_LT(alignment->max_residual_rad, 1e-8);
}

TEST_F(ReferenceAlignmentTest, NeedsThreeSharedImages) {
  EXPECT_FALSE(AlignToKeyframes(reconstruction_, {Keyframe(1), Keyframe(3)}));
}

TEST_F(ReferenceAlignmentTest, IgnoresNamesThatOccurTwiceInTheMap) {
  KeyframeRecord other_drive = Keyframe(3);
  other_drive.cam_from_ecef.translation.x() += 1000.0;
  EXPECT_FALSE(
      AlignToKeyframes(reconstruction_, {Keyframe(1), Keyframe(2), Keyframe(3), other_drive}));
}

TEST_F(ReferenceAlignmentTest, CamerasAtOnePlaceDetermineNoScale) {
  for (ReconImage& image : reconstruction_.images) {
    image.cam_from_world.translation.setZero();
  }
  EXPECT_FALSE(AlignToKeyframes(reconstruction_, {Keyframe(1), Keyframe(2), Keyframe(3)}));
}

TEST_F(ReferenceAlignmentTest, ReportsWhatDoesNotFit) {
  std::vector<KeyframeRecord> keyframes;
  for (int i = 0; i < 10; ++i) {
    keyframes.push_back(Keyframe(i));
  }
  const Eigen::Quaterniond turn(ExpSo3(Eigen::Vector3d(0.0, 0.0, 0.2)));
  keyframes[4].cam_from_ecef = Rigid3d(turn, Eigen::Vector3d::Zero()) * keyframes[4].cam_from_ecef;
  const auto alignment = AlignToKeyframes(reconstruction_, keyframes);
  ASSERT_TRUE(alignment);
  EXPECT_GT(alignment->max_residual_rad, 0.15);
}

// A segment of the map with positions of its own stands elsewhere, and pulls nothing.
TEST_F(ReferenceAlignmentTest, APartElsewhereDoesNotMoveTheReference) {
  const Eigen::Quaterniond none = Eigen::Quaterniond::Identity();
  const Rigid3d elsewhere(none, Eigen::Vector3d(2.0, -3.0, 1.0));
  std::vector<KeyframeRecord> keyframes;
  for (int i = 0; i < 10; ++i) {
    keyframes.push_back(Keyframe(i));
    if (i >= 6) {
      keyframes.back().cam_from_ecef = keyframes.back().cam_from_ecef * elsewhere;
    }
  }
  const auto alignment = AlignToKeyframes(reconstruction_, keyframes);
  ASSERT_TRUE(alignment);
  EXPECT_EQ(alignment->num_shared_images, 10);
  EXPECT_EQ(alignment->num_fitting_images, 6);
  EXPECT_NEAR(alignment->ecef_from_world.scale, ecef_from_world_.scale, 1e-8);
  EXPECT_LT(alignment->median_residual_m, 1e-6);
  EXPECT_NEAR(alignment->max_residual_m, elsewhere.translation.norm(), 1e-6);
}

// A map of another shape than the model: its radii are compared with errors of both.
TEST_F(ReferenceAlignmentTest, TellsHowFarTheShapesDiffer) {
  std::vector<KeyframeRecord> keyframes;
  for (int i = 0; i < 10; ++i) {
    const double bend_m = 0.1 * (i % 2 == 0 ? 1.0 : -1.0);
    const Eigen::Quaterniond none = Eigen::Quaterniond::Identity();
    keyframes.push_back(Keyframe(i));
    keyframes.back().cam_from_ecef =
        Rigid3d(none, Eigen::Vector3d(0.0, bend_m, 0.0)) * keyframes.back().cam_from_ecef;
  }
  const auto alignment = AlignToKeyframes(reconstruction_, keyframes);
  ASSERT_TRUE(alignment);
  EXPECT_NEAR(alignment->radius68_m, 0.1, 0.02);
  EXPECT_LT(alignment->radius68_rad, 1e-6);
}

}  // namespace
}  // namespace cairn
