#include "engine/answer/answer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "engine/answer/view_recall.h"
#include "engine/tiles/pose_share.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

// A hypothesis without matches: what is tested here is the choice.
PoseHypothesis HypothesisAt(const Eigen::Vector3d& center_in_anchor, double evidence) {
  PoseHypothesis hypothesis;
  hypothesis.estimate.cam_from_anchor = {Eigen::Quaterniond::Identity(), -center_in_anchor};
  hypothesis.estimate.evidence = evidence;
  hypothesis.estimate.log_volume = -10.0;
  hypothesis.estimate.covariance = Eigen::Matrix<double, 6, 6>::Identity() * 0.01;
  hypothesis.correspondences = std::make_shared<const std::vector<Correspondence>>();
  return hypothesis;
}

PoseHypothesis AsItIs(const PoseHypothesis& hypothesis) { return hypothesis; }

// A prior of 10 m about the origin.
SearchRegion SomeRegion() {
  SearchRegion region;
  region.origin = Geodetic::FromDegrees(47.0, 8.0, 0.0);
  region.ecef_from_anchor = EcefFromEnu(region.origin);
  region.has_prior = true;
  region.prior_sigma_m = 10.0;
  region.radius_m = 50.0;
  return region;
}

double ScoreOf(const Eigen::Vector3d& center_in_anchor, double evidence) {
  return evidence +
         LogPoseShare(SomeRegion(), center_in_anchor, HypothesisAt(center_in_anchor, 0.0).estimate);
}

LocalizeResult Conclude(
    const std::vector<PoseHypothesis>& hypotheses, const AnswerOptions& options = {},
    const std::function<PoseHypothesis(const PoseHypothesis&)>& refine = AsItIs) {
  QueryContext query;
  query.region = SomeRegion();
  return ConcludeAnswer(query, {}, hypotheses, options, refine, {});
}

TEST(ConcludeAnswer, TakesTheBestScore) {
  const LocalizeResult result =
      Conclude({HypothesisAt({1, 0, 0}, 60.0), HypothesisAt({20, 0, 0}, 140.0)});
  ASSERT_TRUE(result.localized);
  EXPECT_DOUBLE_EQ(result.score, ScoreOf({20, 0, 0}, 140.0));
  EXPECT_NEAR(result.cam_from_anchor.Inverse().translation.x(), 20.0, 1e-12);
  // The 68 % radius of an isotropic Gaussian with sigma 0.1 m.
  EXPECT_NEAR(result.position_accuracy_m,
              AnswerOptions{}.calibration.position_accuracy_factor * 0.18724, 1e-4);
}

// Only the winner is refined, and what it is then decides whether it is good enough.
TEST(ConcludeAnswer, JudgesTheWinnerAsRefined) {
  const auto refine_to = [](double evidence) {
    return [evidence](const PoseHypothesis& winner) {
      PoseHypothesis refined = winner;
      refined.estimate.evidence = evidence;
      refined.estimate.cam_from_anchor.translation.y() -= 0.5;
      return refined;
    };
  };
  const std::vector<PoseHypothesis> hypotheses = {HypothesisAt({1, 0, 0}, 2.0),
                                                  HypothesisAt({20, 0, 0}, 26.0)};
  EXPECT_EQ(Conclude(hypotheses).reason, NotLocalizedReason::kTooFewInliers);
  const LocalizeResult result = Conclude(hypotheses, {}, refine_to(50.0));
  ASSERT_TRUE(result.localized);
  EXPECT_DOUBLE_EQ(result.score, ScoreOf({20, 0.5, 0}, 50.0));
  EXPECT_NEAR(result.cam_from_anchor.Inverse().translation.x(), 20.0, 1e-12);
  EXPECT_NEAR(result.cam_from_anchor.Inverse().translation.y(), 0.5, 1e-12);
  EXPECT_EQ(Conclude({HypothesisAt({1, 0, 0}, 60.0)}, {}, refine_to(20.0)).reason,
            NotLocalizedReason::kTooFewInliers);
}

TEST(ConcludeAnswer, SaysAmbiguousWhenTheRunnerUpIsFarAndAboutAsGood) {
  const LocalizeResult result =
      Conclude({HypothesisAt({0, 0, 0}, 100.0), HypothesisAt({20, 0, 0}, 96.0)});
  EXPECT_FALSE(result.localized);
  EXPECT_EQ(result.reason, NotLocalizedReason::kAmbiguous);
}

// A hypothesis whose inliers are the keypoints [begin, end).
PoseHypothesis HypothesisOf(const Eigen::Vector3d& center_in_anchor, double evidence, int begin,
                            int end) {
  PoseHypothesis hypothesis = HypothesisAt(center_in_anchor, evidence);
  std::vector<Correspondence> correspondences;
  for (int keypoint_idx = begin; keypoint_idx < end; ++keypoint_idx) {
    hypothesis.estimate.inliers.push_back(static_cast<int>(correspondences.size()));
    hypothesis.estimate.right_probabilities.push_back(1.0);
    Correspondence& match = correspondences.emplace_back();
    match.keypoint_idx = keypoint_idx;
    match.x_in_anchor = center_in_anchor + Eigen::Vector3d(0, 0, 10);  // In view.
  }
  hypothesis.correspondences =
      std::make_shared<const std::vector<Correspondence>>(std::move(correspondences));
  return hypothesis;
}

// The evidence of the winner of two, 0 if the answer is ambiguous. No keypoint has a place: poses
// only.
double WinningEvidence(const PoseHypothesis& a, const PoseHypothesis& b,
                       const AnswerOptions& options = {}) {
  QueryContext query;
  query.camera = Camera(CameraModel::kPinhole, 640, 480, {500, 500, 320, 240});
  query.keypoints.resize(200);
  query.region = SomeRegion();
  query.region.has_prior = false;
  const std::vector<TileView> tiles = {
      {std::make_shared<const SearchableTile>(testing::RandomTile(),
                                              std::make_shared<Codebook>(testing::RandomCodebook()),
                                              IndexOptions()),
       Rigid3d()}};
  const LocalizeResult result = ConcludeAnswer(query, tiles, {a, b}, options, AsItIs, {});
  EXPECT_EQ(result.localized, result.reason != NotLocalizedReason::kAmbiguous);
  return result.localized
             ? std::round(result.score -
                          LogPoseShare(query.region, Eigen::Vector3d::Zero(), a.estimate))
             : 0.0;
}

TEST(ConcludeAnswer, KeypointsThatOnlyOneExplainsDecide) {
  const PoseHypothesis best = HypothesisOf({0, 0, 0}, 140.0, 0, 100);
  // 20 keypoints speak for the one, none for the other, 80 tell nothing.
  EXPECT_EQ(WinningEvidence(best, HypothesisOf({20, 0, 0}, 138.0, 20, 100)), 140.0);
  // 60 for the one, 40 for the other: chance does that.
  EXPECT_EQ(WinningEvidence(best, HypothesisOf({20, 0, 0}, 138.0, 60, 140)), 0.0);
  // 10 against none, but only a tenth of all inliers.
  EXPECT_EQ(WinningEvidence(best, HypothesisOf({20, 0, 0}, 138.0, 10, 100)), 0.0);
}

TEST(ConcludeAnswer, MoreKeypointsOutdoASaturatedScore) {
  const PoseHypothesis crowded = HypothesisOf({20, 0, 0}, 138.0, 0, 100);
  EXPECT_EQ(WinningEvidence(HypothesisOf({0, 0, 0}, 140.0, 20, 90), crowded), 138.0);
}

TEST(ConcludeAnswer, ARunnerUpNearbyIsTheSamePose) {
  EXPECT_TRUE(Conclude({HypothesisAt({0, 0, 0}, 60.0), HypothesisAt({1, 0, 0}, 59.0)}).localized);
}

// The prior is evidence, not a wall: what speaks for a pose far from it may outweigh it.
TEST(ConcludeAnswer, AnswersFarFromThePriorAndSaysSo) {
  const LocalizeResult far = Conclude({HypothesisAt({80, 0, 0}, 100.0)});
  ASSERT_TRUE(far.localized);
  EXPECT_TRUE(far.prior_disagrees);
  const LocalizeResult near = Conclude({HypothesisAt({8, 0, 0}, 100.0)});
  ASSERT_TRUE(near.localized);
  EXPECT_FALSE(near.prior_disagrees);
  EXPECT_LT(far.score, near.score);
  EXPECT_LE(far.confidence, near.confidence);
}

TEST(ConcludeAnswer, SaysPriorMismatchIfThePriorOutweighsThePose) {
  ASSERT_TRUE(Conclude({HypothesisAt({0, 0, 0}, 40.0)}).localized);
  const LocalizeResult result = Conclude({HypothesisAt({400, 0, 0}, 40.0)});
  EXPECT_FALSE(result.localized);
  EXPECT_EQ(result.reason, NotLocalizedReason::kPriorMismatch);
}

TEST(ConcludeAnswer, ThePriorDecidesBetweenEqualPoses) {
  const LocalizeResult result =
      Conclude({HypothesisAt({80, 0, 0}, 40.0), HypothesisAt({5, 0, 0}, 40.0)});
  ASSERT_TRUE(result.localized);
  EXPECT_FALSE(result.prior_disagrees);
}

TEST(ConcludeAnswer, SaysTooFewInliersBelowTheThreshold) {
  EXPECT_EQ(Conclude({HypothesisAt({0, 0, 0}, 15.0)}).reason, NotLocalizedReason::kTooFewInliers);
}

// A focal length that is estimated leaves the distance open, which the score does not know.
TEST(ConcludeAnswer, IsNoAnswerIfTheCameraLeavesThePositionOpen) {
  PoseHypothesis wide = HypothesisAt({1, 0, 0}, 140.0);
  wide.estimate.covariance.bottomRightCorner<3, 3>() *= 900.0;  // 3 m an axis.
  const LocalizeResult known = Conclude({wide});
  EXPECT_TRUE(known.localized);
  EXPECT_LT(known.confidence, 0.5);
  wide.camera.emplace();
  const LocalizeResult estimated = Conclude({wide});
  EXPECT_FALSE(estimated.localized);
  EXPECT_EQ(estimated.reason, NotLocalizedReason::kTooFewInliers);
  wide.estimate.covariance *= 0.01;
  EXPECT_TRUE(Conclude({wide}).localized);
}

TEST(ConcludeAnswer, ScalesTheAccuraciesAsCalibrated) {
  AnswerOptions options;
  options.calibration.position_accuracy_factor = 3.0;
  options.calibration.rotation_accuracy_factor = 2.0;
  options.calibration.map_accuracy_m = 0.25;
  const LocalizeResult result = Conclude({HypothesisAt({1, 0, 0}, 60.0)}, options);
  const double predicted = std::sqrt(3.506 * 0.01);
  EXPECT_NEAR(result.position_accuracy_m, 3.0 * predicted, 1e-4);
  EXPECT_NEAR(result.rotation_accuracy_rad, 2.0 * predicted, 1e-4);
  EXPECT_NEAR(result.covariance(0, 0), 4.0 * 0.01, 1e-12);
  EXPECT_NEAR(result.covariance(5, 5), 9.0 * 0.01, 1e-12);
  // Nobody knows how accurate the map is.
  EXPECT_EQ(result.map_accuracy_m, 0.25);
  EXPECT_NEAR(result.EarthAccuracyM(), std::hypot(3.0 * predicted, 0.25), 1e-4);
  EXPECT_DOUBLE_EQ(result.confidence,
                   RecallConfidence(1.0) *
                       options.calibration.Confidence(result.score, result.position_accuracy_m));
  EXPECT_DOUBLE_EQ(result.false_alarm_rate, options.calibration.FalseAlarmRate(result.score));
}

}  // namespace
}  // namespace cairn
