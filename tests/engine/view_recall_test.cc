#include "engine/answer/view_recall.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "support/tile_builder.h"

namespace cairn {
namespace {

constexpr int kNumLandmarks = 100;

// A tile with a wall of landmarks 10 m in front of a keyframe at the origin that looks along z.
TileView MakeWall() {
  testing::RandomTileOptions options;
  options.num_landmarks = kNumLandmarks;
  options.num_keyframes = 0;
  Tile tile = testing::RandomTile(options);
  tile.keyframes.push_back({KeyframeId(1), SessionId(1), Rigid3d()});
  for (uint32_t i = 0; i < kNumLandmarks; ++i) {
    tile.x_in_tile[i] = Eigen::Vector3f(0.1f * static_cast<float>(i % 10),
                                        0.1f * static_cast<float>(i / 10), 10.0f);
    tile.keyframe_landmarks.push_back(i);
  }
  tile.keyframe_begin.push_back(kNumLandmarks);
  return {std::make_shared<SearchableTile>(
              std::move(tile), std::make_shared<const Codebook>(testing::RandomCodebook()),
              IndexOptions()),
          Rigid3d()};
}

class ViewRecallTest : public ::testing::Test {
 protected:
  // Recall at a pose whose inliers are the first landmarks, each right with `probability`.
  double RecallAt(const Rigid3d& anchor_from_cam, int num_inliers, double probability = 1.0,
                  int num_keypoints = 1'000'000) const {
    QueryContext query;
    query.camera = camera_;
    query.keypoints.resize(num_keypoints);
    PoseHypothesis hypothesis;
    hypothesis.estimate.cam_from_anchor = anchor_from_cam.Inverse();
    std::vector<Correspondence> correspondences(num_inliers);
    for (int i = 0; i < num_inliers; ++i) {
      correspondences[i].keypoint_idx = i;
      correspondences[i].landmark_idx = static_cast<uint32_t>(i);
      hypothesis.estimate.inliers.push_back(i);
      hypothesis.estimate.right_probabilities.push_back(probability);
    }
    hypothesis.correspondences =
        std::make_shared<const std::vector<Correspondence>>(std::move(correspondences));
    return ViewRecall(query, {wall_}, camera_, hypothesis);
  }

  Camera camera_{CameraModel::kPinhole, 640, 480, {500, 500, 320, 240}};
  TileView wall_ = MakeWall();
};

TEST_F(ViewRecallTest, IsTheShareOfLandmarksInView) {
  EXPECT_NEAR(RecallAt(Rigid3d(), 50), 0.5, 0.01);
  EXPECT_NEAR(RecallAt(Rigid3d(), 50, 0.4), 0.2, 0.01);
  EXPECT_NEAR(RecallAt(Rigid3d(), 2), 0.03, 0.01);
}

TEST_F(ViewRecallTest, ExpectsLessFromElsewhere) {
  const Rigid3d behind(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, -15));
  EXPECT_GT(RecallAt(behind, 20), 1.5 * RecallAt(Rigid3d(), 20));
  const Rigid3d beside(Eigen::Quaterniond(Eigen::AngleAxisd(-0.6, Eigen::Vector3d::UnitY())),
                       Eigen::Vector3d(6, 0, 1));
  EXPECT_GT(RecallAt(beside, 20), 1.5 * RecallAt(Rigid3d(), 20));
}

TEST_F(ViewRecallTest, ExpectsLessOfFewKeypoints) {
  EXPECT_NEAR(RecallAt(Rigid3d(), 25, 1.0, 100), 26.0 / 51.0, 0.01);
}

TEST_F(ViewRecallTest, IsOneIfNothingIsExpected) {
  const Rigid3d away(Eigen::Quaterniond(Eigen::AngleAxisd(3.1416, Eigen::Vector3d::UnitY())),
                     Eigen::Vector3d::Zero());
  EXPECT_EQ(RecallAt(away, 6), 1.0);
}

TEST(RecallConfidence, RisesFromDoubtToCertainty) {
  EXPECT_LT(RecallConfidence(0.01), 0.05);
  EXPECT_NEAR(RecallConfidence(0.028), 0.5, 1e-9);
  EXPECT_GT(RecallConfidence(0.1), 0.99);
}

}  // namespace
}  // namespace cairn
