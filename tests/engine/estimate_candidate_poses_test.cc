// Tests EstimateCandidatePoses.
#include "engine/pose/estimate_candidate_poses.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <vector>

#include "support/pose_scene.h"

namespace cairn {
namespace {

using testing::MakePoseScene;
using testing::PoseScene;
using testing::PoseSceneOptions;

constexpr double kSureEvidence = 120.0;
constexpr double kNeverSure = std::numeric_limits<double>::infinity();

PoseScene SureScene() {
  PoseSceneOptions options;
  options.num_keypoints = 200;
  options.num_inliers = 120;
  return MakePoseScene(options);
}

// Estimates poses from candidates that all hold all matches.
PoseHypotheses EstimateAll(const PoseScene& scene, int num_candidates, double sure_evidence) {
  const auto matches = std::make_shared<const std::vector<Correspondence>>(scene.correspondences);
  const std::vector<PoseCandidate> candidates(num_candidates,
                                              {.correspondences = scene.AllIndices()});
  const PoseOptions options;
  TriedPoses tried =
      EstimateCandidatePoses(scene.query, matches, candidates, {options, sure_evidence, 1}, {}, {});
  EXPECT_TRUE(tried.is_complete);
  return std::move(tried.hypotheses);
}

TEST(EstimateCandidatePoses, ASurePoseIsFoundOnce) {
  const PoseScene scene = SureScene();
  EXPECT_EQ(EstimateAll(scene, 6, kNeverSure).all().size(), 6u);
  const PoseHypotheses found = EstimateAll(scene, 6, kSureEvidence);
  ASSERT_EQ(found.all().size(), 1u);
  EXPECT_GE(found.all().front().estimate.evidence, kSureEvidence);
}

// Where facades repeat, a candidate holds the matches of several poses. The best of them must not
// hide the others.
TEST(EstimateCandidatePoses, ASurePoseHidesNoRivals) {
  constexpr int kNumRepeated = 90;
  const Eigen::Vector3d period_in_anchor(20.0, 0.0, 0.0);
  PoseScene scene = SureScene();
  std::vector<Correspondence> with_repeated;
  for (const Correspondence& match : scene.correspondences) {
    with_repeated.push_back(match);
    if (match.keypoint_idx < kNumRepeated) {
      with_repeated.push_back(match);
      with_repeated.back().x_in_anchor += period_in_anchor;
    }
  }
  scene.correspondences = with_repeated;
  const Eigen::Vector3d center = scene.center_in_anchor();
  const auto num_at = [&](const PoseHypotheses& found, const Eigen::Vector3d& place) {
    int count = 0;
    for (const PoseHypothesis& hypothesis : found.all()) {
      count += (hypothesis.estimate.cam_from_anchor.Inverse().translation - place).norm() < 1.0;
    }
    return count;
  };
  const PoseHypotheses found = EstimateAll(scene, 2, kSureEvidence);
  EXPECT_EQ(num_at(found, center), 1);
  EXPECT_EQ(num_at(found, center + period_in_anchor), 1);
  EXPECT_EQ(num_at(EstimateAll(scene, 2, kNeverSure), center), 2);
}

}  // namespace
}  // namespace cairn
