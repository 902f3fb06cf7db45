// Tests reported covariances against the errors of many noisy estimates.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "engine/pose/estimate_pose.h"
#include "engine/pose/pose_residuals.h"
#include "support/cameras.h"
#include "support/pose_scene.h"

namespace cairn {
namespace {

using testing::MakePoseScene;
using testing::PoseScene;
using testing::PoseSceneOptions;

struct Consistency {
  int num_estimates = 0;
  double mean_nees = 0.0;  // Normalized estimation error squared; 6 if the covariance is right.
  Eigen::Matrix<double, 6, 1> variance_ratio;  // Empirical over reported, per axis.
};

Consistency Measure(const PoseSceneOptions& base, const PoseOptions& pose_options) {
  constexpr int kNumRuns = 300;
  Consistency consistency;
  Eigen::Matrix<double, 6, 1> empirical = Eigen::Matrix<double, 6, 1>::Zero(), reported = empirical;
  for (int i = 0; i < kNumRuns; ++i) {
    PoseSceneOptions options = base;
    options.seed = 1000 + i;
    const PoseScene scene = MakePoseScene(options);
    const auto estimate =
        EstimatePose(scene.query, scene.correspondences, scene.AllIndices(), pose_options, 1);
    if (!estimate) {
      continue;
    }
    // estimate = truth perturbed on the left by the error.
    const Rigid3d estimated = estimate->cam_from_anchor.Inverse();
    const Rigid3d truth = scene.cam_from_anchor.Inverse();
    PoseTangent error;
    error << LogSo3(estimated.rotation * truth.rotation.conjugate()),
        estimated.translation - truth.translation;
    consistency.mean_nees += error.dot(estimate->covariance.ldlt().solve(error));
    empirical += error.cwiseAbs2();
    reported += estimate->covariance.diagonal();
    ++consistency.num_estimates;
  }
  consistency.mean_nees /= consistency.num_estimates;
  consistency.variance_ratio = empirical.cwiseQuotient(reported);
  return consistency;
}

void ExpectConsistent(const Consistency& consistency) {
  EXPECT_GE(consistency.num_estimates, 298);
  EXPECT_GT(consistency.mean_nees, 6.0 * 0.5);
  EXPECT_LT(consistency.mean_nees, 6.0 * 1.6);
  for (int i = 0; i < 6; ++i) {
    EXPECT_GT(consistency.variance_ratio[i], 0.4) << i;
    EXPECT_LT(consistency.variance_ratio[i], 2.0) << i;
  }
  ::testing::Test::RecordProperty("mean_nees", std::to_string(consistency.mean_nees));
}

PoseSceneOptions CovarianceScene() {
  PoseSceneOptions options;
  options.num_keypoints = 100;
  options.num_inliers = 60;
  options.pixel_noise_px = 1.0;
  options.gravity_noise_rad = 0.0175;
  return options;
}

TEST(PoseCovariance, MatchesErrorsWithGravity) {
  ExpectConsistent(Measure(CovarianceScene(), PoseOptions()));
}

TEST(PoseCovariance, MatchesErrorsWithoutGravity) {
  PoseSceneOptions options = CovarianceScene();
  options.has_gravity = false;
  ExpectConsistent(Measure(options, PoseOptions()));
}

TEST(PoseCovariance, MatchesErrorsWithLandmarkNoise) {
  PoseSceneOptions options = CovarianceScene();
  options.landmark_noise_m = 0.05;
  ExpectConsistent(Measure(options, PoseOptions()));
}

TEST(PoseCovariance, MatchesErrorsOfFisheye) {
  PoseSceneOptions options = CovarianceScene();
  options.camera = testing::OneCameraPerModel().back();
  ExpectConsistent(Measure(options, PoseOptions()));
}

TEST(PoseCovariance, ChiSquareMakesUpForNoiseTakenTooSmall) {
  PoseOptions pose_options;
  pose_options.keypoint_sigma_px = 0.5;  // Half the truth.
  ExpectConsistent(Measure(CovarianceScene(), pose_options));
}

}  // namespace
}  // namespace cairn
