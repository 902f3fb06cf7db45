// Tests GuidedMatches.
#include "engine/refinement/guided_matches.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/angles.h"
#include "engine/simple_tile.h"

namespace cairn {
namespace {

using testing::SimpleQuery;
using testing::SimpleTile;
using testing::SimpleView;

constexpr double kDepthM = 10.0;
constexpr double kSizeM = 0.1;  // Of the landmarks of a SimpleTile.

// A camera at the origin of the tile that looks along z, where a keyframe saw all landmarks.
class GuidedMatchesTest : public ::testing::Test {
 protected:
  // Adds a landmark and returns its pixel.
  Eigen::Vector2d AddLandmark(double x_m, float descriptor) {
    const Eigen::Vector3d x_in_tile(x_m, 0.0, kDepthM);
    landmarks_.push_back({landmarks_.size() + 1, {{descriptor}}, x_in_tile});
    return *camera_.Project(x_in_tile);
  }
  void AddKeypoint(const Eigen::Vector2d& pixel, float descriptor, double size_factor = 1.0) {
    keypoints_.push_back(
        {.x_px = static_cast<float>(pixel.x()),
         .y_px = static_cast<float>(pixel.y()),
         .scale_px = static_cast<float>(size_factor * kSizeM * camera_.focal_px() / kDepthM)});
    descriptors_.push_back({descriptor});
  }
  std::vector<Correspondence> Matches(double sigma_m = 0.001) const {
    std::vector<uint32_t> all;
    for (uint32_t i = 0; i < landmarks_.size(); ++i) {
      all.push_back(i);
    }
    const std::vector<TileView> tiles = {SimpleView(SimpleTile(landmarks_, {all}))};
    QueryContext query = SimpleQuery(descriptors_);
    query.camera = camera_;
    query.keypoints = keypoints_;
    PoseEstimate estimate;
    estimate.covariance.diagonal().tail<3>().setConstant(sigma_m * sigma_m);
    return GuidedMatches(query, tiles, estimate, PoseOptions());
  }

  Camera camera_;

 private:
  std::vector<testing::SimpleLandmark> landmarks_;
  std::vector<Keypoint> keypoints_;
  std::vector<testing::SimpleDescriptor> descriptors_;
};

TEST_F(GuidedMatchesTest, ComparesALandmarkWithTheKeypointsWhereItShouldBe) {
  const Eigen::Vector2d left = AddLandmark(-2.0, 0.5f), right = AddLandmark(2.0, 1.5f);
  AddKeypoint(right, -0.6f);  // Fits the left landmark only, which is elsewhere.
  AddKeypoint(left + Eigen::Vector2d(1.0, 0.0), 0.7f);
  AddKeypoint(left + Eigen::Vector2d(-1.0, 1.0), 1.4f);  // Fits the right landmark better.
  AddKeypoint(right + Eigen::Vector2d(0.0, 1.0), 1.4f);
  const std::vector<Correspondence> matches = Matches();
  ASSERT_EQ(matches.size(), 3u);
  EXPECT_EQ(matches[0].keypoint_idx, 1);
  EXPECT_EQ(matches[0].landmark_idx, 0u);
  EXPECT_NEAR(matches[0].descriptor_sq_distance, 0.04f, 1e-5f);
  EXPECT_EQ(matches[1].keypoint_idx, 2);
  EXPECT_EQ(matches[1].landmark_idx, 0u);
  EXPECT_EQ(matches[2].keypoint_idx, 3);
  EXPECT_EQ(matches[2].landmark_idx, 1u);
}

TEST_F(GuidedMatchesTest, LeavesKeypointsOfAnotherSize) {
  const Eigen::Vector2d pixel = AddLandmark(0.0, 0.5f);
  AddKeypoint(pixel, 0.5f, 4.0);
  AddKeypoint(pixel, 0.5f, 0.25);
  EXPECT_TRUE(Matches().empty());
  AddKeypoint(pixel, 0.5f, 1.5);
  EXPECT_EQ(Matches().size(), 1u);
}

TEST_F(GuidedMatchesTest, SearchesAsFarAsThePoseIsUncertain) {
  const Eigen::Vector2d pixel = AddLandmark(0.0, 0.5f);
  AddKeypoint(pixel + Eigen::Vector2d(40.0, 0.0), 0.5f);
  EXPECT_TRUE(Matches(0.001).empty());
  const std::vector<Correspondence> matches = Matches(0.5);
  ASSERT_EQ(matches.size(), 1u);
  EXPECT_GT(matches[0].search_area_sq_px, kPi * 40.0 * 40.0);
}

// Cells of a fixed size would take a gigabyte.
TEST_F(GuidedMatchesTest, WorksInTheLargestImage) {
  constexpr int kSidePx = Camera::kMaxSidePx;
  camera_ = Camera(CameraModel::kPinhole, kSidePx, kSidePx, {5e4, 5e4, 5e4, 5e4});
  const Eigen::Vector2d left = AddLandmark(-9.0, 0.5f), right = AddLandmark(9.0, 1.5f);
  AddKeypoint(right + Eigen::Vector2d(1.0, 0.0), 1.5f);
  AddKeypoint(left, 0.5f);
  AddKeypoint({1e11, 1e11}, 0.5f);  // Outside of the image.
  const std::vector<Correspondence> matches = Matches();
  ASSERT_EQ(matches.size(), 2u);
  EXPECT_EQ(matches[0].landmark_idx, 1u);
  EXPECT_EQ(matches[1].landmark_idx, 0u);
}

TEST_F(GuidedMatchesTest, ALandmarkOutOfViewHasNoMatch) {
  AddLandmark(1000.0, 0.5f);
  AddKeypoint({639.0, 240.0}, 0.5f);
  EXPECT_TRUE(Matches().empty());
}

}  // namespace
}  // namespace cairn
