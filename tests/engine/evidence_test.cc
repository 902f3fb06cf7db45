#include "engine/pose/evidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/keypoint_shape.h"
#include "engine/pose/effective_inliers.h"
#include "engine/pose/landmark_density.h"
#include "support/pose_scene.h"

namespace cairn {
namespace {

using testing::MakePoseScene;
using testing::PoseScene;
using testing::PoseSceneOptions;

PoseScene AllRight(int num_keypoints = 60) {
  PoseSceneOptions options;
  options.num_keypoints = options.num_inliers = num_keypoints;
  return MakePoseScene(options);
}

std::vector<int> FirstIndices(int count) {
  std::vector<int> indices(count);
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

PoseEvidence Weigh(const PoseScene& scene, const std::vector<int>& inliers) {
  return WeighEvidence(scene.query, scene.correspondences, inliers, scene.cam_from_anchor);
}

TEST(WeighEvidence, RightMatchesSpeakForThePose) {
  const PoseScene scene = AllRight();
  const PoseEvidence evidence = Weigh(scene, FirstIndices(60));
  EXPECT_GT(evidence.log_ratio, 200.0);
  ASSERT_EQ(evidence.right_probabilities.size(), 60u);
  for (const double probability : evidence.right_probabilities) {
    EXPECT_GT(probability, 0.9);
    EXPECT_LE(probability, 1.0);
  }
}

TEST(WeighEvidence, NoInliersSpeakForNothing) { EXPECT_EQ(Weigh(AllRight(), {}).log_ratio, 0.0); }

TEST(WeighEvidence, MoreRightInliersSayMore) {
  const PoseScene scene = AllRight();
  double last = 0.0;
  for (const int count : {6, 12, 25, 50}) {
    const double log_ratio = Weigh(scene, FirstIndices(count)).log_ratio;
    EXPECT_GT(log_ratio, last);
    last = log_ratio;
  }
}

// The same inliers among more keypoints that have found something else are less of a surprise.
TEST(WeighEvidence, KeypointsThatDisagreeWeaken) {
  PoseSceneOptions options;
  options.num_keypoints = 400;
  options.num_inliers = 12;
  const PoseScene scene = MakePoseScene(options);
  PoseScene few = scene;
  few.correspondences.resize(40);
  EXPECT_LT(Weigh(scene, FirstIndices(12)).log_ratio, Weigh(few, FirstIndices(12)).log_ratio);
}

TEST(WeighEvidence, MatchesOfOneKeypointShareItsChance) {
  PoseSceneOptions options;
  options.num_keypoints = options.num_inliers = 20;
  const PoseScene scene = MakePoseScene(options);
  PoseScene many = scene;
  many.correspondences.insert(many.correspondences.end(), scene.correspondences.begin(),
                              scene.correspondences.end());
  EXPECT_LT(Weigh(many, FirstIndices(20)).log_ratio, Weigh(scene, FirstIndices(20)).log_ratio);
}

// Each deviation makes a match less likely, and never says more than the match did.
TEST(WeighEvidence, DeviationsWeaken) {
  const auto ratio = [](const InlierTraits& traits) {
    return LogErrorDensity(traits) + LogTraitRatio(traits);
  };
  const std::pair<double InlierTraits::*, std::vector<double>> kDeviations[] = {
      {&InlierTraits::error_px, {0.1, 1.0, 5.0, 50.0}},
      {&InlierTraits::sq_distance, {0.1, 1.0, 3.0, 10.0}},
      {&InlierTraits::log_size, {0.05, 0.3, 1.0, 3.0}},
      {&InlierTraits::orientation_rad, {0.05, 0.3, 1.0, 3.1}},
      {&InlierTraits::azimuth_rad, {0.05, 0.3, 1.0, 3.1}}};
  for (const auto& [trait, values] : kDeviations) {
    InlierTraits traits{.keypoint_scale_px = 2.0, .landmark_sigma_px = 1.0};
    double last = ratio(traits);
    for (const double value : values) {
      traits.*trait = value;
      EXPECT_LT(ratio(traits), last);
      last = ratio(traits);
    }
  }
}

TEST(WeighEvidence, AMatchWithoutOrientationSaysLess) {
  InlierTraits traits;
  const double with_orientation = LogTraitRatio(traits);
  traits.orientation_rad = -1.0;
  EXPECT_LT(LogTraitRatio(traits), with_orientation);
}

TEST(WeighEvidence, AMatchWithoutSizeSaysLessThanOneThatFits) {
  InlierTraits traits;
  const double fits = LogTraitRatio(traits);
  traits.log_size = 2.0;
  const double contradicts = LogTraitRatio(traits);
  traits.log_size = std::numeric_limits<double>::quiet_NaN();
  EXPECT_LT(LogTraitRatio(traits), fits);
  EXPECT_GT(LogTraitRatio(traits), contradicts);
}

TEST(WeighEvidence, KeypointsWithoutShapeStillSpeakForThePose) {
  PoseScene scene = AllRight();
  const double whole = Weigh(scene, FirstIndices(60)).log_ratio;
  for (Keypoint& keypoint : scene.query.keypoints) {
    keypoint = KeypointWithoutShape(keypoint.x_px, keypoint.y_px);
  }
  const double without = Weigh(scene, FirstIndices(60)).log_ratio;
  EXPECT_GT(without, 0.3 * whole);
}

// An inlier whose descriptor, size and direction are all off does not pull a good pose down.
TEST(WeighEvidence, AnInlierByChanceCostsALittle) {
  PoseScene scene = AllRight();
  const double clean = Weigh(scene, FirstIndices(60)).log_ratio;
  scene.query.same_landmark_distance = 1.0;
  for (int i = 0; i < 5; ++i) {
    scene.correspondences[i].descriptor_sq_distance = 20.0f;
    scene.correspondences[i].size_m *= 10.0f;
  }
  const PoseEvidence evidence = Weigh(scene, FirstIndices(60));
  EXPECT_LT(evidence.right_probabilities.front(), 0.1);
  EXPECT_GT(evidence.right_probabilities.back(), 0.9);
  EXPECT_GT(evidence.log_ratio, 0.8 * clean);
  EXPECT_LT(evidence.log_ratio, clean);
}

// Of many queries whose matches all fell by chance, hardly any pose reaches a few nats: of a pose
// that nobody searched for, exp(-s) at most.
TEST(WeighEvidence, ChanceReachesNothing) {
  PoseSceneOptions options;
  options.num_keypoints = 300;
  options.num_inliers = 0;
  int num_high = 0;
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    options.seed = seed;
    const PoseScene scene = MakePoseScene(options);
    std::vector<int> inliers;
    for (int i = 0; i < 300; ++i) {
      const auto traits = TraitsOf(scene.query, scene.correspondences[i], scene.cam_from_anchor);
      if (traits && traits->error_px < 8.0) {
        inliers.push_back(i);
      }
    }
    num_high += Weigh(scene, inliers).log_ratio > 3.0;
  }
  EXPECT_LE(num_high, 4);
}

// A match that was sought where the pose predicts it says less than one found anywhere.
TEST(WeighEvidence, WhatThePosePredictsSaysLess) {
  const PoseScene scene = AllRight();
  PoseScene predicted = scene;
  for (Correspondence& match : predicted.correspondences) {
    match.search_area_sq_px = 100.0f;
  }
  const double found = Weigh(scene, FirstIndices(60)).log_ratio;
  const double sought = Weigh(predicted, FirstIndices(60)).log_ratio;
  EXPECT_GT(sought, 0.0);
  EXPECT_LT(sought, 0.7 * found);
}

TEST(WeighEvidence, CrowdedInliersAreNotIndependent) {
  const PoseScene spread = AllRight();
  PoseScene crowded = spread;
  // All keypoints and landmarks where the first ones are, but for a pixel or two.
  for (size_t i = 1; i < crowded.query.keypoints.size(); ++i) {
    Keypoint& keypoint = crowded.query.keypoints[i];
    keypoint = crowded.query.keypoints.front();
    keypoint.x_px += 0.02f * static_cast<float>(i);
    Correspondence& match = crowded.correspondences[i];
    const int keypoint_idx = match.keypoint_idx;
    match = crowded.correspondences.front();
    match.keypoint_idx = keypoint_idx;
  }
  EXPECT_LT(Weigh(crowded, FirstIndices(60)).log_ratio,
            0.2 * Weigh(spread, FirstIndices(60)).log_ratio);
}

TEST(WeighEvidence, WorksWithRigs) {
  PoseSceneOptions options;
  options.other_cameras = testing::SideCameras();
  options.num_keypoints = options.num_inliers = 60;
  const PoseScene scene = MakePoseScene(options);
  EXPECT_GT(Weigh(scene, FirstIndices(60)).log_ratio, 100.0);
}

TEST(LandmarkDensity, IsHighWhereLandmarksCrowd) {
  PoseScene scene = AllRight(200);
  const Eigen::Vector3d far_away = scene.cam_from_anchor.Inverse() * Eigen::Vector3d(0, 0, 1000);
  for (Correspondence& match : scene.correspondences) {
    match.x_in_anchor = far_away;
  }
  const LandmarkDensity density(scene.query, scene.correspondences, scene.cam_from_anchor, 0);
  EXPECT_GT(density.At({320, 240}), 100.0 * density.At({10, 10}));
  EXPECT_GT(density.At({10, 10}), 0.0);
}

// Nearly all landmarks of a right pose are in the image: the shares of its pixels sum to one.
TEST(LandmarkDensity, IsADensity) {
  const PoseScene scene = AllRight(500);
  const LandmarkDensity density(scene.query, scene.correspondences, scene.cam_from_anchor, 0);
  const Camera& camera = scene.query.camera;
  double sum = 0.0;
  for (int y = 0; y < camera.height_px(); ++y) {
    for (int x = 0; x < camera.width_px(); ++x) {
      sum += density.At({x + 0.5, y + 0.5});
    }
  }
  EXPECT_NEAR(sum, 1.0, 0.05);
}

}  // namespace
}  // namespace cairn
