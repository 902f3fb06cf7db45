// Tests RefineEstimate and RefineOnLikelyInliers.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "core/angles.h"
#include "engine/pose/estimate_pose.h"
#include "engine/pose/evidence.h"
#include "engine/scene_estimate.h"
#include "support/pose_scene.h"

namespace cairn {
namespace {

using testing::Estimate;
using testing::IsRight;
using testing::MakePoseScene;
using testing::PoseScene;
using testing::PoseSceneOptions;

// What a few matches gave is judged by all of them.
TEST(RefineEstimate, TakesTheInliersAmongOtherMatches) {
  PoseSceneOptions options;
  options.num_inliers = 80;
  const PoseScene scene = MakePoseScene(options);
  const std::vector<Correspondence> few(scene.correspondences.begin(),
                                        scene.correspondences.begin() + 10);
  const std::vector<int> all_of_few = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  const auto of_few = EstimatePose(scene.query, few, all_of_few, PoseOptions(), 1);
  ASSERT_TRUE(of_few);
  const auto refined = RefineEstimate(scene.query, scene.correspondences, *of_few, PoseOptions());
  ASSERT_TRUE(IsRight(refined, scene));
  EXPECT_GE(refined->inliers.size(), 75u);
  EXPECT_GT(refined->evidence, 3.0 * of_few->evidence);
  EXPECT_EQ(refined->right_probabilities.size(), refined->inliers.size());
  EXPECT_LT(refined->covariance.trace(), of_few->covariance.trace());
  EXPECT_EQ(refined->consensus, of_few->consensus);
  EXPECT_EQ(refined->num_iterations, of_few->num_iterations);
}

// The volume counts the poses that the inliers cannot tell apart, and gravity those that it leaves.
TEST(RefineEstimate, MeasuresThePosesThatFitAsWell) {
  PoseSceneOptions options;
  options.num_inliers = 80;
  PoseScene scene = MakePoseScene(options);
  const auto estimate = Estimate(scene);
  ASSERT_TRUE(estimate);
  EXPECT_NEAR(estimate->log_volume,
              0.5 * std::log((2.0 * kPi * estimate->covariance).determinant()), 1e-6);
  ASSERT_TRUE(scene.query.down_in_cam);
  const double sigma_rad = PoseOptions().gravity_sigma_rad;
  const double at_best = -std::log(2.0 * kPi * sigma_rad * sigma_rad);
  EXPECT_LE(estimate->log_tilt_density, at_best);
  EXPECT_GT(estimate->log_tilt_density, at_best - 5.0);
  // Gravity that is far off says nothing.
  const Eigen::AngleAxisd turn(0.5, scene.query.down_in_cam->unitOrthogonal());
  scene.query.down_in_cam = turn * *scene.query.down_in_cam;
  const auto refined = RefineEstimate(scene.query, scene.correspondences, *estimate, PoseOptions());
  ASSERT_TRUE(refined);
  EXPECT_EQ(refined->log_tilt_density, 0.0);
}

TEST(RefineEstimate, NothingFromMatchesThatDisagree) {
  PoseSceneOptions options;
  options.num_inliers = 80;
  const PoseScene scene = MakePoseScene(options);
  const auto estimate = Estimate(scene);
  ASSERT_TRUE(estimate);
  PoseEstimate elsewhere = *estimate;
  elsewhere.cam_from_anchor.translation.x() += 100.0;
  EXPECT_FALSE(RefineEstimate(scene.query, scene.correspondences, elsewhere, PoseOptions()));
  EXPECT_FALSE(RefineEstimate(scene.query, {}, *estimate, PoseOptions()));
}

// Landmarks moved to one side, within the threshold, by matches that do not look like right ones.
TEST(RefineOnLikelyInliers, IsNotPulledByUnlikelyMatches) {
  constexpr int kNumMoved = 30;
  PoseSceneOptions options;
  options.num_inliers = 80;
  PoseScene scene = MakePoseScene(options);
  const Eigen::Vector3d right_in_anchor =
      scene.cam_from_anchor.rotation.conjugate() * Eigen::Vector3d::UnitX();
  for (int i = 0; i < kNumMoved; ++i) {
    Correspondence& match = scene.correspondences[i];
    const double depth_m = (scene.cam_from_anchor * match.x_in_anchor).z();
    match.x_in_anchor += 3.0 * depth_m / scene.query.camera.focal_px() * right_in_anchor;
    match.size_m *= 8.0f;
  }
  const auto pulled = Estimate(scene);
  ASSERT_TRUE(pulled);
  const PoseEstimate refined =
      RefineOnLikelyInliers(scene.query, scene.correspondences, *pulled, PoseOptions());
  EXPECT_GT(refined.evidence, pulled->evidence);
  const auto mean_right_error_px = [&](const Rigid3d& cam_from_anchor) {
    double sum_px = 0.0;
    for (int i = kNumMoved; i < options.num_inliers; ++i) {
      sum_px += TraitsOf(scene.query, scene.correspondences[i], cam_from_anchor)->error_px;
    }
    return sum_px / (options.num_inliers - kNumMoved);
  };
  EXPECT_LT(mean_right_error_px(refined.cam_from_anchor),
            mean_right_error_px(pulled->cam_from_anchor));
  EXPECT_EQ(refined.right_probabilities.size(), refined.inliers.size());
}

TEST(RefineOnLikelyInliers, LeavesAPoseOfLikelyInliersAlone) {
  PoseSceneOptions options;
  options.num_keypoints = options.num_inliers = 80;
  const PoseScene scene = MakePoseScene(options);
  const auto estimate = Estimate(scene);
  ASSERT_TRUE(estimate);
  const PoseEstimate refined =
      RefineOnLikelyInliers(scene.query, scene.correspondences, *estimate, PoseOptions());
  EXPECT_EQ(refined.cam_from_anchor.ToMatrix(), estimate->cam_from_anchor.ToMatrix());
}

}  // namespace
}  // namespace cairn
