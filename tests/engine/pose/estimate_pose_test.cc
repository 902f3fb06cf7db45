#include "engine/pose/estimate_pose.h"

#include <gtest/gtest.h>

#include "support/pose_scene.h"

namespace cairn {
namespace {

using testing::CenterErrorM;
using testing::MakePoseScene;
using testing::PoseScene;
using testing::PoseSceneOptions;

std::optional<PoseEstimate> Estimate(const PoseScene& scene, const PoseOptions& options = {},
                                     uint64_t seed = 1) {
  return EstimatePose(scene.query, scene.correspondences, scene.AllIndices(), options, seed);
}

TEST(EstimatePose, RecoversExactPoseWithoutNoise) {
  for (bool has_gravity : {true, false}) {
    PoseSceneOptions options;
    options.num_inliers = options.num_keypoints;
    options.pixel_noise_px = 0.0;
    options.has_gravity = has_gravity;
    const PoseScene scene = MakePoseScene(options);
    const auto estimate = Estimate(scene);
    ASSERT_TRUE(estimate);
    EXPECT_LT(CenterErrorM(estimate->cam_from_anchor, scene.cam_from_anchor), 1e-4);
    EXPECT_LT(RotationAngleRad(estimate->cam_from_anchor.rotation, scene.cam_from_anchor.rotation),
              1e-5);
    EXPECT_EQ(estimate->inliers.size(), 100u);
  }
}

TEST(EstimatePose, FindsFivePercentInliersUnderGravityNoise) {
  int num_found = 0;
  for (int seed = 1; seed <= 20; ++seed) {
    PoseSceneOptions options;
    options.num_keypoints = 1000;
    options.num_inliers = 50;
    options.gravity_noise_rad = 0.0175;
    options.pixel_noise_px = 1.0;
    options.seed = seed;
    const PoseScene scene = MakePoseScene(options);
    const auto estimate = Estimate(scene);
    if (estimate && CenterErrorM(estimate->cam_from_anchor, scene.cam_from_anchor) < 0.5)
      ++num_found;
    else
      printf("seed %d est %d inl %zu its %d\n", seed, !!estimate,
             estimate ? estimate->inliers.size() : 0, estimate ? estimate->num_iterations : 0);
  }
  EXPECT_GE(num_found, 19);
}

}  // namespace
}  // namespace cairn
