#include "engine/pose/refine_pose.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "engine/pose/pose_residuals.h"
#include "support/cameras.h"
#include "support/pose_scene.h"

namespace cairn {
namespace {

using testing::CenterErrorM;
using testing::PoseScene;
using testing::PoseSceneOptions;

std::vector<PoseObservation> Observations(const PoseScene& scene) {
  std::vector<PoseObservation> observations;
  for (const Correspondence& match : scene.correspondences) {
    const Keypoint& keypoint = scene.query.keypoints[match.keypoint_idx];
    observations.push_back({{keypoint.x_px, keypoint.y_px}, match.x_in_anchor, match.sigma_m});
  }
  return observations;
}

Rigid3d Disturb(const Rigid3d& cam_from_anchor) {
  PoseTangent tangent;
  tangent << 0.05, -0.03, 0.04, 0.8, -0.6, 0.5;
  return PerturbPose(cam_from_anchor.Inverse(), tangent).Inverse();
}

PoseSceneOptions InliersOnly(int num_keypoints) {
  PoseSceneOptions options;
  options.num_keypoints = options.num_inliers = num_keypoints;
  options.pixel_noise_px = 0.0;
  return options;
}

TEST(RefinePose, ConvergesToTruthForEveryCameraModel) {
  for (const Camera& camera : testing::OneCameraPerModel()) {
    PoseSceneOptions options = InliersOnly(60);
    options.camera = camera;
    const PoseScene scene = MakePoseScene(options);
    const RefinedPose refined =
        RefinePose(camera, Observations(scene), std::nullopt, Disturb(scene.cam_from_anchor), {});
    EXPECT_LT(CenterErrorM(refined.cam_from_anchor, scene.cam_from_anchor), 1e-4)
        << CameraModelName(camera.model());
    EXPECT_GT(refined.num_iterations, 0);
  }
}

TEST(RefinePose, ResistsOutliers) {
  PoseSceneOptions options = InliersOnly(100);
  options.num_inliers = 75;
  options.pixel_noise_px = 0.5;
  const PoseScene scene = MakePoseScene(options);
  RefinePoseOptions refine_options;
  refine_options.max_iterations = 50;
  const RefinedPose refined = RefinePose(scene.query.camera, Observations(scene), std::nullopt,
                                         scene.cam_from_anchor, refine_options);
  EXPECT_LT(CenterErrorM(refined.cam_from_anchor, scene.cam_from_anchor), 0.1);
}

TEST(RefinePose, UncertainLandmarksWeighLess) {
  // Half of the landmarks are off by meters and say so.
  PoseSceneOptions options = InliersOnly(60);
  options.pixel_noise_px = 0.2;
  const PoseScene scene = MakePoseScene(options);
  std::vector<PoseObservation> observations = Observations(scene);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal(0.0, 0.5);
  for (size_t i = 0; i < observations.size(); i += 2) {
    observations[i].x_in_anchor += Eigen::Vector3d(normal(random), normal(random), normal(random));
    observations[i].sigma_m = 0.5;
  }
  const auto error = [&] {
    return CenterErrorM(RefinePose(scene.query.camera, observations, std::nullopt,
                                   Disturb(scene.cam_from_anchor), {})
                            .cam_from_anchor,
                        scene.cam_from_anchor);
  };
  const double weighted_error = error();
  EXPECT_LT(weighted_error, 0.05);
  for (PoseObservation& observation : observations) {
    observation.sigma_m = 0.0;
  }
  EXPECT_GT(error(), weighted_error);
}

TEST(RefinePose, GravityPriorFixesWhatFewPointsLeaveFree) {
  PoseSceneOptions options = InliersOnly(2);
  const PoseScene scene = MakePoseScene(options);
  const GravityPrior gravity = {*scene.query.down_in_cam, 0.01};
  RefinePoseOptions refine_options;
  refine_options.max_iterations = 50;
  const RefinedPose refined = RefinePose(scene.query.camera, Observations(scene), gravity,
                                         Disturb(scene.cam_from_anchor), refine_options);
  EXPECT_LT(GravityResidual(gravity.down_in_cam, refined.cam_from_anchor.Inverse(), nullptr).norm(),
            1e-3);
}

TEST(RefinePose, RigWithAllObservationsInOneCameraIsThatCameraMoved) {
  PoseSceneOptions options;
  options.num_inliers = options.num_keypoints;
  const PoseScene scene = MakePoseScene(options);
  const Rigid3d own_from_first = testing::SideCameras()[1].cam_from_first;
  const std::vector<QueryRigCamera> others = {{scene.query.camera, own_from_first}};
  std::vector<PoseObservation> observations = Observations(scene);
  const RefinedPose single = RefinePose(scene.query.camera, observations, std::nullopt,
                                        Disturb(scene.cam_from_anchor), {});
  const auto single_covariance =
      PoseCovariance(scene.query.camera, observations, std::nullopt, single.cam_from_anchor, {});
  for (PoseObservation& observation : observations) {
    observation.camera_idx = 1;
  }
  const RefinedPose rig =
      RefinePose(Camera(), observations, std::nullopt,
                 own_from_first.Inverse() * Disturb(scene.cam_from_anchor), {}, others);
  const Rigid3d expected = own_from_first.Inverse() * single.cam_from_anchor;
  EXPECT_LT(CenterErrorM(rig.cam_from_anchor, expected), 1e-5);
  EXPECT_LT(RotationAngleRad(rig.cam_from_anchor.rotation, expected.rotation), 1e-6);
  // The first camera moves by translation - rotation x offset if its fellow moves by both.
  Eigen::Matrix<double, 6, 6> first_by_own = Eigen::Matrix<double, 6, 6>::Identity();
  first_by_own.bottomLeftCorner<3, 3>() =
      Skew(single.cam_from_anchor.Inverse().translation - expected.Inverse().translation);
  const auto rig_covariance =
      PoseCovariance(Camera(), observations, std::nullopt, rig.cam_from_anchor, {}, others);
  const Eigen::Matrix<double, 6, 6> covariance =
      first_by_own * single_covariance * first_by_own.transpose();
  EXPECT_LT((rig_covariance - covariance).norm(), 1e-3 * covariance.norm());
}

TEST(RefinePose, FreeDirectionsHaveLargeFiniteVariance) {
  const RefinedPose refined = RefinePose(Camera(), {}, std::nullopt, Rigid3d(), {});
  EXPECT_TRUE(refined.cam_from_anchor.ToMatrix().isApprox(Rigid3d().ToMatrix()));
  const auto covariance = PoseCovariance(Camera(), {}, std::nullopt, refined.cam_from_anchor, {});
  EXPECT_TRUE(covariance.allFinite());
  EXPECT_NEAR(covariance(0, 0), 9.0, 1e-9);
  EXPECT_NEAR(covariance(3, 3), 1e6, 1e-3);
}

TEST(RefinePose, LandmarksBehindTheCameraAreGrossOutliers) {
  PoseSceneOptions options = InliersOnly(40);
  const PoseScene scene = MakePoseScene(options);
  std::vector<PoseObservation> observations = Observations(scene);
  observations[0].x_in_anchor = scene.cam_from_anchor.Inverse() * Eigen::Vector3d(0, 0, -10);
  const RefinedPose refined = RefinePose(scene.query.camera, observations, std::nullopt,
                                         Disturb(scene.cam_from_anchor), {});
  EXPECT_LT(CenterErrorM(refined.cam_from_anchor, scene.cam_from_anchor), 1e-3);
}

// Without noise, only the prior of four residuals of the stated size speaks for noise.
TEST(RefinePose, CovarianceIsInverseOfNormalMatrix) {
  const PoseScene scene = MakePoseScene(InliersOnly(50));
  const auto observations = Observations(scene);
  const RefinedPose refined =
      RefinePose(scene.query.camera, observations, std::nullopt, scene.cam_from_anchor, {});
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  const PosedCamera camera(scene.query.camera, refined.cam_from_anchor.Inverse());
  Eigen::Matrix<double, 2, 3> pixel_by_anchor;
  for (const PoseObservation& observation : observations) {
    ASSERT_TRUE(ProjectLandmark(camera, observation.x_in_anchor, &pixel_by_anchor));
    const auto jacobian =
        ReprojectionJacobian(pixel_by_anchor, observation.x_in_anchor - camera.center_in_anchor);
    normal += jacobian.transpose() * jacobian;
  }
  const auto covariance =
      PoseCovariance(scene.query.camera, observations, std::nullopt, refined.cam_from_anchor, {});
  const double scale = 4.0 / (4.0 + 2.0 * 50.0 - 6.0);
  EXPECT_TRUE(
      (covariance * normal).isApprox(scale * Eigen::Matrix<double, 6, 6>::Identity(), 1e-3));
}

// Errors of many estimates against what they say of themselves, with keypoints that are better and
// worse than keypoint_sigma_px.
// The squared error of the position in standard deviations by the covariance: 3 in the mean if that
// is right.
double SqPositionError(const PoseScene& scene, const std::vector<PoseObservation>& observations,
                       const Rigid3d& refined) {
  const Eigen::Vector3d error = refined.Inverse().translation - scene.center_in_anchor();
  const auto covariance =
      PoseCovariance(scene.query.camera, observations, std::nullopt, refined, {});
  return error.dot(covariance.bottomRightCorner<3, 3>().inverse() * error);
}

TEST(RefinePose, CovarianceFollowsTheResiduals) {
  constexpr int kNumRuns = 100;
  for (const double noise_px : {0.2, 1.0, 3.0}) {
    double sum = 0.0;
    for (int run = 0; run < kNumRuns; ++run) {
      PoseSceneOptions options = InliersOnly(80);
      options.pixel_noise_px = noise_px;
      options.seed = 10 + run;
      const PoseScene scene = MakePoseScene(options);
      const auto observations = Observations(scene);
      const RefinedPose refined =
          RefinePose(scene.query.camera, observations, std::nullopt, scene.cam_from_anchor, {});
      sum += SqPositionError(scene, observations, refined.cam_from_anchor);
    }
    EXPECT_NEAR(sum / kNumRuns, 3.0, 1.2) << noise_px;
  }
}

TEST(RefinePose, CovarianceGrowsWhenNoiseWasTakenTooSmall) {
  PoseSceneOptions options = InliersOnly(200);
  options.pixel_noise_px = 1.0;
  const PoseScene scene = MakePoseScene(options);
  RefinePoseOptions right, optimistic;
  right.keypoint_sigma_px = 1.0;
  optimistic.keypoint_sigma_px = 0.5;
  const auto trace = [&](const RefinePoseOptions& refine_options) {
    const auto observations = Observations(scene);
    const RefinedPose refined = RefinePose(scene.query.camera, observations, std::nullopt,
                                           scene.cam_from_anchor, refine_options);
    return PoseCovariance(scene.query.camera, observations, std::nullopt, refined.cam_from_anchor,
                          refine_options)
        .trace();
  };
  EXPECT_NEAR(trace(optimistic) / trace(right), 1.0, 0.5);
}

// Landmarks that a mapping camera 3 m beside the query's saw: 5 % of their distance off, along its
// rays, independently and, by `common_sigmas` standard deviations, all alike.
std::vector<PoseObservation> OffAlongRays(const PoseScene& scene, bool knows_shapes,
                                          double common_sigmas = 0.0) {
  const Rigid3d anchor_from_cam = scene.cam_from_anchor.Inverse();
  const Eigen::Vector3d mapped_from = anchor_from_cam * Eigen::Vector3d(3.0, 0.0, 0.0);
  const PosedCamera camera(scene.query.camera, anchor_from_cam);
  std::vector<PoseObservation> observations = Observations(scene);
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  for (PoseObservation& observation : observations) {
    const Eigen::Vector3d ray = observation.x_in_anchor - mapped_from;
    const double sigma_m = 0.05 * ray.norm();
    observation.x_in_anchor += (normal(random) + common_sigmas) * sigma_m * ray.normalized();
    observation.sigma_m = sigma_m / std::sqrt(3.0);
    if (knows_shapes) {
      observation.error_shape = ErrorShapeAt(
          camera, observation.x_in_anchor, {0.05 * 0.05 * ray * ray.transpose(), 0.05 * ray}, 1.0);
    }
  }
  return observations;
}

TEST(RefinePose, WeighsTheErrorsOfLandmarksByTheirShapes) {
  constexpr int kNumRuns = 100;
  double round_m = 0.0, shaped_m = 0.0, sum_sq = 0.0;
  for (int run = 0; run < kNumRuns; ++run) {
    PoseSceneOptions options = InliersOnly(80);
    options.pixel_noise_px = 1.0;
    options.seed = 10 + run;
    const PoseScene scene = MakePoseScene(options);
    const Camera& camera = scene.query.camera;
    const auto refine = [&](const std::vector<PoseObservation>& observations) {
      return RefinePose(camera, observations, std::nullopt, scene.cam_from_anchor, {})
          .cam_from_anchor;
    };
    round_m += CenterErrorM(refine(OffAlongRays(scene, false)), scene.cam_from_anchor);
    const auto observations = OffAlongRays(scene, true);
    const Rigid3d refined = refine(observations);
    shaped_m += CenterErrorM(refined, scene.cam_from_anchor);
    sum_sq += SqPositionError(scene, observations, refined);
  }
  EXPECT_LT(shaped_m, 0.6 * round_m);
  EXPECT_NEAR(sum_sq / kNumRuns, 3.0, 1.2);
}

// The covariance holds what a common error of distances does to the pose, however many landmarks
// there are.
TEST(RefinePose, CovarianceIncludesThatDistancesErrAlike) {
  double sum_sq = 0.0;
  constexpr int kNumRuns = 100;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0.0, 0.1);
  for (int run = 0; run < kNumRuns; ++run) {
    PoseSceneOptions options = InliersOnly(2000);
    options.pixel_noise_px = 1.0;
    options.seed = 10 + run;
    const PoseScene scene = MakePoseScene(options);
    const auto observations = OffAlongRays(scene, true, normal(random));
    const RefinedPose refined =
        RefinePose(scene.query.camera, observations, std::nullopt, scene.cam_from_anchor, {});
    sum_sq += SqPositionError(scene, observations, refined.cam_from_anchor);
  }
  EXPECT_NEAR(sum_sq / kNumRuns, 3.0, 1.2);
}

}  // namespace
}  // namespace cairn
