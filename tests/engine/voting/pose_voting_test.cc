#include "engine/voting/pose_voting.h"

#include <gtest/gtest.h>

#include "support/pose_scene.h"
#include "support/voting_truth.h"

namespace cairn {
namespace {

using testing::MakePoseScene;
using testing::PoseScene;
using testing::PoseSceneOptions;
using testing::RankOfTruth;

TEST(VoteForPoses, FindsTruthWithoutNoise) {
  PoseSceneOptions options;
  options.num_inliers = options.num_keypoints;
  options.pixel_noise_px = 0.0;
  const PoseScene scene = MakePoseScene(options);
  StageCounters counters;
  const auto candidates =
      VoteForPoses(scene.query, scene.correspondences, VotingOptions(), &counters);
  EXPECT_EQ(RankOfTruth(scene, candidates), 0);
}

}  // namespace
}  // namespace cairn
