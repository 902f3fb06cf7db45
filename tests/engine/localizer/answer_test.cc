#include "engine/answer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

namespace cairn {
namespace {

// A hypothesis without matches: what is tested here is the choice.
PoseHypothesis HypothesisAt(const Eigen::Vector3d& center_in_anchor, double effective_inliers) {
  PoseHypothesis hypothesis;
  hypothesis.estimate.cam_from_anchor = {Eigen::Quaterniond::Identity(), -center_in_anchor};
  hypothesis.estimate.effective_inliers = effective_inliers;
  hypothesis.estimate.covariance = Eigen::Matrix<double, 6, 6>::Identity() * 0.01;
  hypothesis.correspondences = std::make_shared<const std::vector<Correspondence>>();
  return hypothesis;
}

LocalizeResult Conclude(const std::vector<PoseHypothesis>& hypotheses,
                        const AnswerOptions& options = {}) {
  QueryContext query;
  query.region.origin = Geodetic::FromDegrees(47.0, 8.0, 0.0);
  query.region.ecef_from_anchor = EcefFromEnu(query.region.origin);
  query.region.has_prior = true;
  query.region.radius_m = 50.0;
  LocalizeResult result;
  ConcludeAnswer(query, {}, hypotheses, options, &result);
  return result;
}

TEST(ConcludeAnswer, TakesTheBestScore) {
  const LocalizeResult result =
      Conclude({HypothesisAt({1, 0, 0}, 12.0), HypothesisAt({20, 0, 0}, 40.0)});
  ASSERT_TRUE(result.localized);
  EXPECT_DOUBLE_EQ(result.score, 40.0);
  EXPECT_NEAR(result.cam_from_anchor.Inverse().translation.x(), 20.0, 1e-12);
  // sqrt(3.506 * 0.01): the 68 % radius of an isotropic Gaussian with sigma 0.1 m.
  EXPECT_NEAR(result.position_accuracy_m, AnswerOptions{}.calibration.PositionAccuracyM(0.18724),
              1e-4);
}

TEST(ConcludeAnswer, SaysAmbiguousWhenTheRunnerUpIsFarAndAboutAsGood) {
  const LocalizeResult result =
      Conclude({HypothesisAt({0, 0, 0}, 40.0), HypothesisAt({20, 0, 0}, 36.0)});
  EXPECT_FALSE(result.localized);
  EXPECT_EQ(result.reason, NotLocalizedReason::kAmbiguous);
}

TEST(ConcludeAnswer, ARunnerUpNearbyIsTheSamePose) {
  EXPECT_TRUE(Conclude({HypothesisAt({0, 0, 0}, 40.0), HypothesisAt({1, 0, 0}, 39.0)}).localized);
}

TEST(ConcludeAnswer, SaysPriorMismatchWhenTheGoodPoseIsOutside) {
  const LocalizeResult result = Conclude({HypothesisAt({80, 0, 0}, 40.0)});
  EXPECT_FALSE(result.localized);
  EXPECT_EQ(result.reason, NotLocalizedReason::kPriorMismatch);
}

TEST(ConcludeAnswer, SaysTooFewInliersBelowTheThreshold) {
  EXPECT_EQ(Conclude({HypothesisAt({0, 0, 0}, 5.0)}).reason, NotLocalizedReason::kTooFewInliers);
}

TEST(ConcludeAnswer, ScalesTheAccuraciesAsCalibrated) {
  AnswerOptions options;
  options.calibration.position_accuracy_factor = 3.0;
  options.calibration.rotation_accuracy_factor = 2.0;
  options.calibration.map_accuracy_m = 0.25;
  const LocalizeResult result = Conclude({HypothesisAt({1, 0, 0}, 12.0)}, options);
  const double predicted = std::sqrt(3.506 * 0.01);
  EXPECT_NEAR(result.position_accuracy_m, std::hypot(3.0 * predicted, 0.25), 1e-9);
  EXPECT_NEAR(result.rotation_accuracy_rad, 2.0 * predicted, 1e-9);
  EXPECT_DOUBLE_EQ(result.confidence, options.calibration.Confidence(12.0));
}

}  // namespace
}  // namespace cairn
