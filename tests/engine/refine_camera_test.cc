#include "engine/pose/refine_camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "engine/pose/estimate_pose.h"
#include "engine/pose/pose_ransac_problem.h"
#include "engine/pose/pose_residuals.h"
#include "support/cameras.h"
#include "support/pose_scene.h"

namespace cairn {
namespace {

using testing::CenterErrorM;
using testing::MakePoseScene;
using testing::PoseScene;
using testing::PoseSceneOptions;

PoseSceneOptions CameraScene(uint64_t seed) {
  PoseSceneOptions options;
  options.num_keypoints = options.num_inliers = 80;
  options.gravity_noise_rad = 0.0175;
  options.pixel_noise_px = 1.0;
  options.seed = seed;
  return options;
}

std::vector<PoseObservation> ObservationsOf(const PoseScene& scene) {
  std::vector<PoseObservation> observations;
  for (size_t i = 0; i < scene.correspondences.size(); ++i) {
    const Correspondence& match = scene.correspondences[i];
    const Keypoint& keypoint = scene.query.keypoints[match.keypoint_idx];
    if (scene.is_correct[i]) {
      observations.push_back({{keypoint.x_px, keypoint.y_px}, match.x_in_anchor, match.sigma_m});
    }
  }
  return observations;
}

CameraPrior PriorOff(const Camera& truth, double factor, double log_sigma) {
  return {WithFocalScaled(truth, factor), FocalPrior{.log_sigma = log_sigma}};
}

// From the true pose, but for what the wrong focal length makes of it.
RefinedCamera Refine(const PoseScene& scene, const CameraPrior& prior) {
  const std::vector<PoseObservation> observations = ObservationsOf(scene);
  const auto gravity = MakeGravityPrior(scene.query, PoseOptions());
  const RefinedPose start =
      RefinePose(prior.camera, observations, gravity, scene.cam_from_anchor, RefinePoseOptions());
  return RefineCamera(prior, prior.camera, observations, gravity, start.cam_from_anchor,
                      RefinePoseOptions());
}

double LogFocalError(const RefinedCamera& refined, const Camera& truth) {
  return std::log(refined.camera.focal_px() / truth.focal_px());
}

TEST(RefineCamera, FindsTheFocalLengthOfEveryModel) {
  for (const Camera& camera : testing::OneCameraPerModel()) {
    PoseSceneOptions options = CameraScene(3);
    options.camera = camera;
    const PoseScene scene = MakePoseScene(options);
    for (const double factor : {0.8, 0.95, 1.05, 1.25}) {
      const RefinedCamera refined = Refine(scene, PriorOff(camera, factor, 0.3));
      EXPECT_LT(std::abs(LogFocalError(refined, camera)), 4.0 * refined.focal_log_sigma)
          << CameraModelName(camera.model()) << " " << factor;
      EXPECT_LT(refined.focal_log_sigma, 0.02);
      EXPECT_LT(CenterErrorM(refined.cam_from_anchor, scene.cam_from_anchor), 0.5);
      EXPECT_EQ(refined.camera.model(), camera.model());
    }
  }
}

TEST(RefineCamera, FindsTheDistortionWhereItIsUnknown) {
  PoseSceneOptions options = CameraScene(5);
  options.camera = Camera(CameraModel::kSimpleRadial, 640, 480, {520, 320, 240, -0.08});
  const PoseScene scene = MakePoseScene(options);
  const CameraPrior prior = {CameraOfUnknownFocal(640, 480), FocalPrior{.with_distortion = true}};
  const RefinedCamera refined = Refine(scene, prior);
  EXPECT_NEAR(refined.camera.params()[3], -0.08, 0.03);
  EXPECT_NEAR(refined.camera.focal_px(), 520.0, 15.0);
}

TEST(RefineCamera, StaysWithAStatedFocalLengthThatIsRight) {
  double sum_sq_fixed = 0.0, sum_sq_refined = 0.0;
  for (uint64_t seed = 1; seed <= 50; ++seed) {
    const PoseScene scene = MakePoseScene(CameraScene(seed));
    const RefinedCamera refined = Refine(scene, PriorOff(scene.query.camera, 1.0, 1e-4));
    const RefinedPose fixed = RefinePose(scene.query.camera, ObservationsOf(scene),
                                         MakeGravityPrior(scene.query, PoseOptions()),
                                         scene.cam_from_anchor, RefinePoseOptions());
    sum_sq_fixed += std::pow(CenterErrorM(fixed.cam_from_anchor, scene.cam_from_anchor), 2);
    sum_sq_refined += std::pow(CenterErrorM(refined.cam_from_anchor, scene.cam_from_anchor), 2);
    EXPECT_LT(refined.focal_disagreement, 4.0);
  }
  EXPECT_LT(sum_sq_refined, 1.02 * sum_sq_fixed);
}

TEST(RefineCamera, SaysThatAStatedFocalLengthIsWrong) {
  const PoseScene scene = MakePoseScene(CameraScene(7));
  const RefinedCamera refined = Refine(scene, PriorOff(scene.query.camera, 1.05, 0.01));
  EXPECT_GT(refined.focal_disagreement, 3.0);
  EXPECT_LT(std::abs(LogFocalError(refined, scene.query.camera)), 0.02);
}

// Errors of many estimates, prior and noise drawn anew, against what they say of themselves.
TEST(RefineCamera, CovarianceMatchesErrors) {
  constexpr double kLogSigma = 0.05;
  constexpr int kNumRuns = 200;
  std::mt19937_64 generator(1);
  std::normal_distribution<double> normal(0.0, kLogSigma);
  double sum_sq_focal = 0.0, sum_center = 0.0;
  for (int i = 0; i < kNumRuns; ++i) {
    const PoseScene scene = MakePoseScene(CameraScene(100 + i));
    const RefinedCamera refined =
        Refine(scene, PriorOff(scene.query.camera, std::exp(normal(generator)), kLogSigma));
    sum_sq_focal +=
        std::pow(LogFocalError(refined, scene.query.camera) / refined.focal_log_sigma, 2);
    const Eigen::Vector3d error =
        refined.cam_from_anchor.Inverse().translation - scene.center_in_anchor();
    sum_center += error.dot(refined.covariance.bottomRightCorner<3, 3>().inverse() * error);
  }
  EXPECT_NEAR(sum_sq_focal / kNumRuns, 1.0, 0.35);
  EXPECT_NEAR(sum_center / kNumRuns, 3.0, 1.0);
}

// Principal points and aspects drawn anew, with which a camera in the middle with square pixels is
// off by more than the noise.
TEST(RefineCamera, FindsThePrincipalPointAndTheAspectUnlessTheyAreKnown) {
  constexpr int kNumRuns = 100;
  constexpr double kSigma = 0.01;
  std::mt19937_64 generator(3);
  std::normal_distribution<double> normal;
  double sum = 0.0, sum_known = 0.0, sum_sq_px = 0.0;
  for (int i = 0; i < kNumRuns; ++i) {
    const double x_px = 320.0 + kSigma * 640 * normal(generator);
    const double y_px = 240.0 + kSigma * 640 * normal(generator);
    const double aspect = std::exp(CameraPrior().aspect_sigma * normal(generator));
    PoseSceneOptions options = CameraScene(300 + i);
    options.pixel_noise_px = 0.3;
    options.camera = Camera(CameraModel::kPinhole, 640, 480, {500.0 * aspect, 500.0, x_px, y_px});
    const PoseScene scene = MakePoseScene(options);
    CameraPrior prior = {Camera(CameraModel::kSimplePinhole, 640, 480, {500.0, 320.0, 240.0}),
                         FocalPrior{.log_sigma = 0.05}};
    const auto refine = [&](double* sum_of_squares) {
      const RefinedCamera refined = Refine(scene, prior);
      const Eigen::Vector3d error =
          refined.cam_from_anchor.Inverse().translation - scene.center_in_anchor();
      *sum_of_squares +=
          error.dot(refined.covariance.bottomRightCorner<3, 3>().inverse() * error) / kNumRuns;
      return refined.camera;
    };
    EXPECT_EQ(refine(&sum_known).model(), CameraModel::kSimplePinhole);
    prior.principal_point_sigma = kSigma;
    const Eigen::Vector2d error_px =
        PrincipalPointPx(refine(&sum)) - PrincipalPointPx(options.camera);
    sum_sq_px += error_px.squaredNorm() / (2.0 * kNumRuns);
  }
  EXPECT_GT(sum_known, 2.0 * sum);
  EXPECT_NEAR(sum, 3.0, 1.0);
  EXPECT_LT(std::sqrt(sum_sq_px), 0.7 * kSigma * 640);
}

TEST(RefineCamera, APrincipalPointFarFromTheMiddleDisagrees) {
  PoseSceneOptions options = CameraScene(5);
  options.camera = Camera(CameraModel::kSimplePinhole, 640, 480, {500.0, 450.0, 240.0});
  const PoseScene scene = MakePoseScene(options);
  CameraPrior prior = {Camera(CameraModel::kSimplePinhole, 640, 480, {500.0, 320.0, 240.0}),
                       FocalPrior{.log_sigma = 0.05}};
  prior.principal_point_sigma = 0.0065;
  EXPECT_GT(Refine(scene, prior).principal_point_disagreement, 6.0);
  prior.principal_point_sigma = 0.2;
  EXPECT_NEAR(PrincipalPointPx(Refine(scene, prior).camera).x(), 450.0, 10.0);
}

// A wall seen straight on says nothing about the focal length: twice as far away with twice the
// focal length it looks the same.
TEST(RefineCamera, StaysWithinThePriorAtAFlatWall) {
  constexpr double kDistanceM = 20.0;
  const Camera camera(CameraModel::kSimplePinhole, 640, 480, {500, 320, 240});
  std::vector<PoseObservation> observations;
  std::mt19937_64 generator(2);
  std::uniform_real_distribution<double> x_px(0, 640), y_px(0, 480);
  std::normal_distribution<double> noise_px(0.0, 0.5);
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector2d pixel(x_px(generator), y_px(generator));
    const Eigen::Vector3d x_in_cam = *camera.Unproject(pixel);
    observations.push_back({pixel + Eigen::Vector2d(noise_px(generator), noise_px(generator)),
                            x_in_cam * (kDistanceM / x_in_cam.z()), 0.0});
  }
  const CameraPrior prior = PriorOff(camera, 1.0, 0.1);
  const RefinedCamera refined =
      RefineCamera(prior, camera, observations, std::nullopt, Rigid3d(), RefinePoseOptions());
  EXPECT_NEAR(refined.focal_log_sigma, 0.1, 0.01);
  EXPECT_LT(std::abs(LogFocalError(refined, camera)), 0.02);
  EXPECT_LT(refined.focal_disagreement, 3.0);
  EXPECT_NEAR(std::sqrt(refined.covariance(5, 5)), 0.1 * kDistanceM, 0.3);
}

// Landmarks whose distance from the camera is uncertain say as much of the focal length as exact
// ones: their errors do not show.
TEST(RefineCamera, WeighsTheErrorsOfLandmarksByTheirShapes) {
  const PoseScene scene = MakePoseScene(CameraScene(3));
  const Camera& camera = scene.query.camera;
  const PosedCamera posed(camera, scene.cam_from_anchor.Inverse());
  std::vector<PoseObservation> observations = ObservationsOf(scene);
  const auto focal_sigma = [&] {
    return RefineCamera(PriorOff(camera, 1.0, 0.1), camera, observations, std::nullopt,
                        scene.cam_from_anchor, {})
        .focal_log_sigma;
  };
  const double exact = focal_sigma();
  for (PoseObservation& observation : observations) {
    const Eigen::Vector3d ray = observation.x_in_anchor - posed.center_in_anchor;
    observation.sigma_m = 0.05 * ray.norm() / std::sqrt(3.0);
    observation.error_shape =
        ErrorShapeAt(posed, observation.x_in_anchor, {0.05 * 0.05 * ray * ray.transpose()}, 1.0);
  }
  EXPECT_NEAR(focal_sigma() / exact, 1.0, 0.01);
  for (PoseObservation& observation : observations) {
    observation.error_shape.reset();
  }
  EXPECT_GT(focal_sigma(), 3.0 * exact);
}

}  // namespace
}  // namespace cairn
