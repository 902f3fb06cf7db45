#include "engine/voting/pose_voting.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "engine/pose/estimate_pose.h"
#include "support/cameras.h"
#include "support/pose_scene.h"
#include "support/voting_truth.h"

namespace cairn {
namespace {

using ::testing::IsEmpty;
using testing::MakePoseScene;
using testing::PoseScene;
using testing::PoseSceneOptions;
using testing::RankOfTruth;

std::vector<PoseCandidate> Vote(const PoseScene& scene, const VotingOptions& options = {}) {
  return VoteForPoses(scene.query, scene.correspondences, options).candidates;
}

PoseSceneOptions HardScene(int num_inliers, uint64_t seed) {
  PoseSceneOptions options = testing::HardScene(num_inliers);
  options.seed = seed;
  return options;
}

TEST(VoteForPoses, FindsTruthWithoutNoise) {
  PoseSceneOptions options;
  options.num_inliers = options.num_keypoints;
  options.pixel_noise_px = 0.0;
  for (int seed = 1; seed <= 10; ++seed) {
    options.seed = seed;
    const PoseScene scene = MakePoseScene(options);
    EXPECT_EQ(RankOfTruth(scene, Vote(scene)), 0);
  }
}

TEST(VoteForPoses, FindsSixtyInliersAmongFourThousandMatches) {
  int num_found = 0;
  for (int seed = 1; seed <= 12; ++seed) {
    const PoseScene scene = MakePoseScene(HardScene(60, seed));
    num_found += RankOfTruth(scene, Vote(scene)) >= 0;
  }
  EXPECT_GE(num_found, 11);
}

TEST(VoteForPoses, FindsSixtyInliersByGeometryAlone) {
  VotingOptions options;
  options.max_distance_factor = 0.0;
  options.max_azimuth_difference_rad = 3.14159;
  int num_found = 0;
  for (int seed = 1; seed <= 6; ++seed) {
    const PoseScene scene = MakePoseScene(HardScene(60, seed));
    num_found += RankOfTruth(scene, Vote(scene, options)) >= 0;
  }
  EXPECT_GE(num_found, 5);
}

TEST(VoteForPoses, WorkersDoNotChangeTheResult) {
  const PoseScene scene = MakePoseScene(HardScene(60, 3));
  const auto [alone, num_votes] = VoteForPoses(scene.query, scene.correspondences, VotingOptions());
  ASSERT_FALSE(alone.empty());
  for (const int num_threads : {1, 2, 3, 7}) {
    SharedWorkers workers(num_threads);
    const SharedWorkers::Caller caller(&workers);
    const auto [shared, num_shared_votes] =
        VoteForPoses(scene.query, scene.correspondences, VotingOptions(), &workers);
    EXPECT_EQ(num_shared_votes, num_votes);
    ASSERT_EQ(shared.size(), alone.size());
    for (size_t i = 0; i < alone.size(); ++i) {
      EXPECT_EQ(shared[i].center_in_anchor, alone[i].center_in_anchor);
      EXPECT_EQ(shared[i].yaw_rad, alone[i].yaw_rad);
      EXPECT_EQ(shared[i].score, alone[i].score);
      EXPECT_EQ(shared[i].correspondences, alone[i].correspondences);
    }
  }
}

// Whenever it is told to, it stops at the next heading or candidate, alone and with workers.
TEST(VoteForPoses, LeavesTheRestWhenItIsToldToStop) {
  const PoseScene scene = MakePoseScene(HardScene(60, 3));
  std::atomic<int> num_asked = 0;
  const auto vote = [&](SharedWorkers* workers, int num_questions) {
    num_asked = 0;
    VotedPoses voted = VoteForPoses(scene.query, scene.correspondences, VotingOptions(), workers,
                                    [&] { return ++num_asked > num_questions; });
    EXPECT_EQ(voted.candidates.empty(), num_asked > num_questions) << num_questions;
    return voted;
  };
  const int64_t num_all_votes = vote(nullptr, 1'000'000).num_votes;
  const int num_all = num_asked;
  EXPECT_GT(num_all, 120);  // Headings, and some candidates.
  for (const int num_questions : {0, 10, num_all - 5, num_all - 1}) {
    const VotedPoses voted = vote(nullptr, num_questions);
    EXPECT_THAT(voted.candidates, IsEmpty());
    EXPECT_EQ(voted.num_votes < num_all_votes, num_questions < 100) << num_questions;
  }
  SharedWorkers workers(4);
  const SharedWorkers::Caller caller(&workers);
  EXPECT_LT(vote(&workers, 10).num_votes, num_all_votes);
  EXPECT_EQ(vote(&workers, 1'000'000).num_votes, num_all_votes);
}

TEST(VoteForPoses, FindsTheTruthOfARig) {
  PoseSceneOptions options = HardScene(60, 1);
  options.other_cameras = testing::SideCameras();
  for (QueryRigCamera& other : options.other_cameras) {
    other.cam_from_first.translation *= 4.0;  // Whole cells away.
  }
  int num_found = 0;
  for (options.seed = 1; options.seed <= 6; ++options.seed) {
    const PoseScene scene = MakePoseScene(options);
    num_found += RankOfTruth(scene, Vote(scene)) >= 0;
  }
  EXPECT_GE(num_found, 5);
}

TEST(VoteForPoses, In3dFindsTheTruthUpToItsHeight) {
  VotingOptions options;
  options.filter = OutlierFilter::kVoting3d;
  int num_found = 0;
  for (int seed = 1; seed <= 10; ++seed) {
    const PoseScene scene = MakePoseScene(HardScene(120, seed));
    std::vector<PoseCandidate> candidates = Vote(scene, options);
    for (PoseCandidate& candidate : candidates) {
      candidate.center_in_anchor.z() = scene.center_in_anchor().z();
    }
    const int rank = RankOfTruth(scene, candidates);
    if (rank >= 0) {
      ++num_found;
      const std::vector<int>& subset = candidates[rank].correspondences;
      EXPECT_GE(
          std::count_if(subset.begin(), subset.end(), [&](int i) { return scene.is_correct[i]; }),
          80);
    }
  }
  EXPECT_GE(num_found, 9);
}

TEST(VoteForPoses, In3dNeedsNoHeights) {
  PoseSceneOptions scene_options;
  scene_options.num_inliers = 60;
  PoseScene scene = MakePoseScene(scene_options);
  scene.query.region.min_z_m = -1e4;
  scene.query.region.max_z_m = 1e4;
  VotingOptions options;
  options.filter = OutlierFilter::kVoting3d;
  EXPECT_FALSE(Vote(scene, options).empty());
}

TEST(VoteForPoses, CandidateIsReadyForPoseEstimation) {
  const PoseScene scene = MakePoseScene(HardScene(60, 3));
  const auto candidates = Vote(scene);
  const int rank = RankOfTruth(scene, candidates);
  ASSERT_GE(rank, 0);
  const std::vector<int>& subset = candidates[rank].correspondences;
  EXPECT_TRUE(std::is_sorted(subset.begin(), subset.end()));
  const auto num_correct =
      std::count_if(subset.begin(), subset.end(), [&](int i) { return scene.is_correct[i]; });
  EXPECT_GE(num_correct, 45);
  const auto estimate = EstimatePose(scene.query, scene.correspondences, subset, PoseOptions(), 1);
  ASSERT_TRUE(estimate);
  EXPECT_LT(testing::CenterErrorM(estimate->cam_from_anchor, scene.cam_from_anchor), 0.3);
}

TEST(VoteForPoses, WorksForFisheye) {
  PoseSceneOptions options = HardScene(80, 5);
  options.camera = testing::OneCameraPerModel().back();
  const PoseScene scene = MakePoseScene(options);
  EXPECT_GE(RankOfTruth(scene, Vote(scene)), 0);
}

TEST(VoteForPoses, WorksForTiltedCameras) {
  PoseSceneOptions options;
  options.num_inliers = 60;
  options.max_tilt_rad = 1.2;
  int num_found = 0;
  for (int seed = 1; seed <= 10; ++seed) {
    options.seed = seed;
    const PoseScene scene = MakePoseScene(options);
    num_found += RankOfTruth(scene, Vote(scene)) >= 0;
  }
  EXPECT_GE(num_found, 9);
}

TEST(VoteForPoses, CandidatesAreApartAndInOrder) {
  const auto candidates = Vote(MakePoseScene(HardScene(60, 4)));
  ASSERT_GE(candidates.size(), 2u);
  EXPECT_LE(candidates.size(), 8u);
  for (size_t i = 1; i < candidates.size(); ++i) {
    EXPECT_GE(candidates[i - 1].score, candidates[i].score);
    for (size_t k = 0; k < i; ++k) {
      const bool far =
          (candidates[i].center_in_anchor - candidates[k].center_in_anchor).norm() > 3.0;
      EXPECT_TRUE(far || std::abs(WrapAngleRad(candidates[i].yaw_rad - candidates[k].yaw_rad)) >
                             2.0 * VotingOptions().yaw_step_rad);
    }
  }
}

TEST(VoteForPoses, CandidatesLieInTheRegion) {
  PoseSceneOptions options = HardScene(0, 6);
  options.region_radius_m = 20.0;
  const PoseScene scene = MakePoseScene(options);
  VotingOptions voting_options;
  voting_options.min_score = 0.0;
  const auto candidates = Vote(scene, voting_options);
  EXPECT_FALSE(candidates.empty());
  for (const PoseCandidate& candidate : candidates) {
    EXPECT_LT(candidate.center_in_anchor.head<2>().norm(), 20.0 + 2.0);
    EXPECT_GT(candidate.center_in_anchor.z(), scene.query.region.min_z_m - 2.0);
    EXPECT_LT(candidate.center_in_anchor.z(), scene.query.region.max_z_m + 2.0);
  }
}

TEST(VoteForPoses, OneKeypointCannotMakeACandidateAlone) {
  PoseSceneOptions options;
  options.num_keypoints = 1;
  options.num_inliers = 1;
  options.matches_per_keypoint = 200;
  const auto candidates = Vote(MakePoseScene(options));
  EXPECT_THAT(candidates, IsEmpty());
}

TEST(VoteForPoses, NothingFromNothing) {
  PoseScene scene = MakePoseScene({});
  scene.correspondences.clear();
  EXPECT_THAT(Vote(scene), IsEmpty());
}

TEST(VoteForPoses, NothingIfNoLandmarkIsInReach) {
  PoseScene scene = MakePoseScene({});
  for (Correspondence& match : scene.correspondences) {
    match.x_in_anchor.x() += 10'000.0;
  }
  EXPECT_THAT(Vote(scene), IsEmpty());
}

TEST(VoteForPoses, OpenRegionOfAWholeMapStaysBounded) {
  PoseSceneOptions options;
  options.num_inliers = 80;
  PoseScene scene = MakePoseScene(options);
  scene.query.region.has_prior = false;
  scene.query.region.radius_m = 20'000.0;
  scene.query.region.min_z_m = -1e4;
  scene.query.region.max_z_m = 1e4;
  // One landmark far away stretches the accumulator.
  scene.correspondences.back().x_in_anchor = {15'000.0, -15'000.0, 0.0};
  VotingOptions voting_options;
  const auto candidates = Vote(scene, voting_options);
  ASSERT_FALSE(candidates.empty());
}

TEST(VoteForPoses, CountsVotes) {
  const PoseScene scene = MakePoseScene({});
  const VotedPoses voted = VoteForPoses(scene.query, scene.correspondences, VotingOptions());
  EXPECT_GT(voted.num_votes, 0);
  EXPECT_FALSE(voted.candidates.empty());
}

TEST(VoteForPoses, SameInputSameCandidates) {
  const PoseScene scene = MakePoseScene(HardScene(60, 7));
  const auto first = Vote(scene), second = Vote(scene);
  ASSERT_EQ(first.size(), second.size());
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].center_in_anchor, second[i].center_in_anchor);
    EXPECT_EQ(first[i].correspondences, second[i].correspondences);
  }
}

}  // namespace
}  // namespace cairn
