#include "core/adjust/adjust.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <random>
#include <string>

#include "core/csv.h"
#include "core/error.h"
#include "core/file_bytes.h"
#include "core/focal_length.h"
#include "ingest/colmap/colmap_reader.h"
#include "support/test_data.h"

namespace cairn {
namespace {

using Centers = Eigen::Matrix3Xd;

// Cameras on an arc look at a cloud of points.
struct Scene {
  Reconstruction truth;
  std::mt19937_64 rng{5};

  double Noise(double sigma) { return std::normal_distribution<double>(0.0, sigma)(rng); }
  Eigen::Vector3d Noise3(double sigma) { return {Noise(sigma), Noise(sigma), Noise(sigma)}; }
};

Rigid3d LookAtOrigin(const Eigen::Vector3d& center) {
  Eigen::Matrix3d rotation;
  rotation.row(2) = -center.normalized().transpose();
  rotation.row(0) = Eigen::Vector3d::UnitY().cross(rotation.row(2)).normalized().transpose();
  rotation.row(1) = rotation.row(2).cross(rotation.row(0));
  return {rotation, -(rotation * center)};
}

Scene MakeScene(double pixel_sigma_px, const Camera& camera, int num_images = 10,
                int num_landmarks = 200) {
  Scene scene;
  Reconstruction& model = scene.truth;
  model.cameras = {camera};
  for (int i = 0; i < num_images; ++i) {
    const double angle = -0.6 + 1.2 * i / (num_images - 1);
    ReconImage image;
    image.name = std::to_string(i);
    image.cam_from_world =
        LookAtOrigin(Eigen::Vector3d(8.0 * std::sin(angle), 0.3 * (i % 3), -8.0 * std::cos(angle)));
    model.images.push_back(image);
  }
  for (int i = 0; i < num_landmarks; ++i) {
    ReconLandmark landmark;
    landmark.x_in_world = scene.Noise3(1.5);
    for (int j = 0; j < num_images; ++j) {
      ReconImage& image = model.images[j];
      const auto pixel = camera.Project(image.cam_from_world * landmark.x_in_world);
      if (pixel && camera.Contains(*pixel)) {
        landmark.observations.push_back({j, image.features.size()});
        image.features.keypoints.push_back(
            {static_cast<float>(pixel->x() + scene.Noise(pixel_sigma_px)),
             static_cast<float>(pixel->y() + scene.Noise(pixel_sigma_px)), 2.0f, 0.0f});
      }
    }
    model.landmarks.push_back(landmark);
  }
  for (ReconImage& image : model.images) {
    image.features.descriptors = PackedDescriptors(ByteDescriptorMatrix(image.features.size(), 0));
  }
  return scene;
}

Camera Pinhole() { return {CameraModel::kPinhole, 640, 480, {500.0, 500.0, 320.0, 240.0}}; }

void Perturb(double angle_rad, double distance, Scene* scene, Reconstruction* model) {
  for (ReconImage& image : model->images) {
    const Eigen::Vector3d center =
        image.cam_from_world.Inverse().translation + scene->Noise3(distance);
    const Eigen::Quaterniond rotation =
        ExpSo3(scene->Noise3(angle_rad)) * image.cam_from_world.rotation;
    image.cam_from_world = {rotation, -(rotation * center)};
  }
  for (ReconLandmark& landmark : model->landmarks) {
    landmark.x_in_world += scene->Noise3(distance);
  }
}

Centers CentersOf(const Reconstruction& model) {
  Centers centers(3, model.images.size());
  for (size_t i = 0; i < model.images.size(); ++i) {
    centers.col(i) = model.images[i].cam_from_world.Inverse().translation;
  }
  return centers;
}

Centers PointsOf(const Reconstruction& model) {
  Centers points(3, model.landmarks.size());
  for (size_t i = 0; i < model.landmarks.size(); ++i) {
    points.col(i) = model.landmarks[i].x_in_world;
  }
  return points;
}

// The distances of the columns after the similarity that fits best.
Eigen::VectorXd ErrorsAligned(const Centers& found, const Centers& truth) {
  const Eigen::Matrix4d fit = Eigen::umeyama(found, truth, /*with_scaling=*/true);
  return ((fit.topLeftCorner<3, 3>() * found).colwise() + fit.topRightCorner<3, 1>() - truth)
      .colwise()
      .norm();
}

constexpr CameraFreedom kFixed[] = {CameraFreedom::kFixed};
constexpr CameraFreedom kFocal[] = {CameraFreedom::kFocal};
constexpr CameraFreedom kBent[] = {CameraFreedom::kFocalAndDistortion};

TEST(Adjust, FindsTheSceneThatItsKeypointsShow) {
  Scene scene = MakeScene(0.0, Pinhole());
  Reconstruction model = scene.truth;
  Perturb(0.01, 0.1, &scene, &model);
  AdjustOptions options;
  options.max_error_sigmas = 100.0;
  options.min_relative_change = 1e-12;
  const AdjustReport report = Adjust(kFixed, {}, options, model);
  EXPECT_LT(ErrorsAligned(CentersOf(model), CentersOf(scene.truth)).maxCoeff(), 1e-4);
  EXPECT_LT(report.rms_px, 1e-3);
  EXPECT_LT(report.final_cost, 1e-6 * report.initial_cost);
  EXPECT_EQ(report.num_observations_removed, 0);
}

TEST(Adjust, HoldsTheGauge) {
  Scene scene = MakeScene(0.3, Pinhole());
  Reconstruction model = scene.truth;
  Adjust(kFixed, {}, {}, model);
  const Eigen::Matrix4d fit =
      Eigen::umeyama(CentersOf(model), CentersOf(scene.truth), /*with_scaling=*/true);
  EXPECT_LT((fit - Eigen::Matrix4d::Identity()).norm(), 0.02);
}

TEST(Adjust, FindsTheFocalLengthAndTheDistortion) {
  const Camera bent(CameraModel::kRadial, 640, 480, {500.0, 320.0, 240.0, -0.12, 0.03});
  Scene scene = MakeScene(0.2, bent, 20);
  Reconstruction model = scene.truth;
  model.cameras = {Camera(CameraModel::kSimplePinhole, 640, 480, {525.0, 320.0, 240.0})};
  AdjustOptions options;
  options.max_error_sigmas = 100.0;
  AdjustPriors priors;
  priors.focal_sigma_of_camera = {0.05};
  Adjust(kBent, priors, options, model);
  const std::vector<double>& params = model.cameras[0].params();
  ASSERT_EQ(model.cameras[0].model(), CameraModel::kRadial);
  EXPECT_NEAR(params[0], 500.0, 3.0);
  EXPECT_NEAR(params[3], -0.12, 0.02);
}

// A picture that somebody cut out of another: its keypoints stand elsewhere in it.
TEST(Adjust, FindsThePrincipalPointOfACroppedPicture) {
  Scene scene = MakeScene(0.2, Pinhole());
  scene.truth.cameras.push_back(Pinhole());
  scene.truth.images[3].camera_idx = 1;
  const Eigen::Vector2d moved_px(-90.0, 40.0);
  for (Keypoint& keypoint : scene.truth.images[3].features.keypoints) {
    keypoint.x_px += static_cast<float>(moved_px.x());
    keypoint.y_px += static_cast<float>(moved_px.y());
  }
  const auto error_of = [&](CameraFreedom freedom, Reconstruction* model) {
    *model = scene.truth;
    const CameraFreedom freedoms[] = {CameraFreedom::kFixed, freedom};
    AdjustPriors priors;
    priors.focal_sigma_of_camera = {0.0, 0.15};
    AdjustOptions options;
    options.max_error_sigmas = 100.0;
    Adjust(freedoms, priors, options, *model);
    return ErrorsAligned(CentersOf(*model), CentersOf(scene.truth))[3];
  };
  Reconstruction model;
  EXPECT_LT(error_of(CameraFreedom::kWithPrincipalPoint, &model), 0.03);
  const Eigen::Vector2d expected = PrincipalPointPx(Pinhole()) + moved_px;
  EXPECT_LT((PrincipalPointPx(model.cameras[1]) - expected).norm(), 8.0);
  EXPECT_GT(error_of(CameraFreedom::kFocalAndDistortion, &model), 0.06);
}

TEST(Adjust, HoldsTheFocalLengthThatIsFixed) {
  Scene scene = MakeScene(0.2, Pinhole());
  Reconstruction model = scene.truth;
  Adjust(kFixed, {}, {}, model);
  EXPECT_EQ(model.cameras[0].params(), Pinhole().params());
}

TEST(Adjust, RemovesObservationsThatDoNotFit) {
  Scene scene = MakeScene(0.2, Pinhole());
  int num_wrong = 0;
  for (size_t i = 0; i < scene.truth.landmarks.size(); i += 10) {
    const ReconObservation& seen = scene.truth.landmarks[i].observations[0];
    scene.truth.images[seen.image_idx].features.keypoints[seen.keypoint_idx].x_px += 40.0f;
    ++num_wrong;
  }
  Reconstruction model = scene.truth;
  const AdjustReport report = Adjust(kFixed, {}, {}, model);
  EXPECT_GE(report.num_observations_removed, num_wrong);
  EXPECT_LT(report.num_observations_removed, num_wrong + 10);
  EXPECT_LT(report.rms_px, 0.4);
  EXPECT_LT(ErrorsAligned(CentersOf(model), CentersOf(scene.truth)).maxCoeff(), 0.02);
  EXPECT_NO_THROW(model.Validate());
}

TEST(Adjust, RemovesLandmarksWithoutDepth) {
  Scene scene = MakeScene(0.2, Pinhole());
  Reconstruction model = scene.truth;
  ReconLandmark far = model.landmarks[0];
  far.observations.resize(1);
  ReconLandmark near = model.landmarks[1];
  near.observations.resize(2);  // Neighbors on the arc: 0.13 rad apart.
  model.landmarks[0] = far;
  model.landmarks[1] = near;
  AdjustOptions options;
  options.min_ray_angle_rad = 0.2;
  options.max_error_sigmas = 100.0;
  Adjust(kFixed, {}, options, model);
  EXPECT_GT(model.landmarks.size(), 190u);
  for (const ReconLandmark& landmark : model.landmarks) {
    EXPECT_FALSE(landmark.observations.size() == 2 && landmark.observations.back().image_idx == 1);
  }
}

TEST(Adjust, IsPlacedByItsPositions) {
  Scene scene = MakeScene(0.2, Pinhole());
  Reconstruction model = scene.truth;
  AdjustPriors priors;
  const Eigen::Vector3d shift(10.0, 20.0, -30.0);
  for (const ReconImage& image : model.images) {
    priors.position_of_image.push_back(
        CenterPrior{1.1 * image.cam_from_world.Inverse().translation + shift + scene.Noise3(0.01),
                    Eigen::Vector3d::Constant(0.01)});
  }
  priors.position_of_image[3]->center_in_world.x() += 50.0;  // A receiver that was lost.
  priors.position_of_image[5] = std::nullopt;
  AdjustOptions options;
  options.position_loss_scale_sigmas = 100.0;
  options.max_iterations = 200;
  Adjust(kFixed, priors, options, model);
  const Eigen::Vector3d expected =
      1.1 * scene.truth.images[5].cam_from_world.Inverse().translation + shift;
  EXPECT_LT((model.images[5].cam_from_world.Inverse().translation - expected).norm(), 0.5);
}

TEST(Adjust, HoldsFixedImages) {
  Scene scene = MakeScene(0.2, Pinhole());
  Reconstruction model = scene.truth;
  Perturb(0.002, 0.02, &scene, &model);
  const Reconstruction before = model;
  AdjustPriors priors;
  priors.image_is_fixed.assign(model.images.size(), 1);
  priors.image_is_fixed[4] = 0;
  Adjust(kFixed, priors, {}, model);
  EXPECT_EQ(CentersOf(model).col(0), CentersOf(before).col(0));
  EXPECT_NE(CentersOf(model).col(4), CentersOf(before).col(4));
}

// Landmarks of another model hold the frame, and one observation of each is enough.
TEST(Adjust, FollowsFixedLandmarks) {
  Scene scene = MakeScene(0.0, Pinhole());
  Reconstruction model = scene.truth;
  Perturb(0.01, 0.05, &scene, &model);
  AdjustPriors priors;
  for (size_t i = 0; i < model.landmarks.size(); ++i) {
    const bool is_fixed = i % 4 == 0;
    priors.landmark_is_fixed.push_back(is_fixed ? 1 : 0);
    if (is_fixed) {
      model.landmarks[i].x_in_world = scene.truth.landmarks[i].x_in_world;
    }
  }
  model.landmarks[0].observations.resize(1);
  // A wrong link.
  model.landmarks[4].x_in_world += Eigen::Vector3d(0.0, 1.0, 0.0);
  Adjust(kFixed, priors, {}, model);
  EXPECT_EQ(model.landmarks[0].observations.size(), 1U);
  EXPECT_EQ(model.landmarks[0].x_in_world, scene.truth.landmarks[0].x_in_world);
  for (size_t i = 0; i < model.images.size(); ++i) {
    const Rigid3d truth = scene.truth.images[i].cam_from_world.Inverse();
    const Rigid3d found = model.images[i].cam_from_world.Inverse();
    EXPECT_LT((found.translation - truth.translation).norm(), 1e-4);
    EXPECT_LT(RotationAngleRad(found.rotation, truth.rotation), 1e-4);
  }
}

// Half of the landmarks are so far away that many systems cannot be factored, six of them in a row.
Reconstruction WithFarLandmarks() {
  Reconstruction model = MakeScene(0.3, Pinhole(), 6, 60).truth;
  for (size_t i = 30; i < 60; ++i) {
    model.landmarks[i].x_in_world *= 1e7;
  }
  return model;
}

AdjustOptions ToTheEnd() {
  AdjustOptions options;
  options.max_error_sigmas = 1e9;
  options.min_relative_change = 1e-15;
  return options;
}

TEST(Adjust, GoesOnAfterStepsThatCannotBeComputed) {
  Reconstruction model = WithFarLandmarks();
  EXPECT_NO_THROW(Adjust(kBent, {}, ToTheEnd(), model));
}

TEST(Adjust, PrintsNothing) {
  Reconstruction model = WithFarLandmarks();
  ::testing::internal::CaptureStderr();
  Adjust(kBent, {}, ToTheEnd(), model);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

// Iterations, which so many images of one place ask for, find the poses as a factorization does.
TEST(Adjust, FindsManyImagesOfOnePlace) {
  Scene scene = MakeScene(0.3, Pinhole(), 405, 40);
  Reconstruction model = scene.truth;
  Perturb(0.003, 0.02, &scene, &model);
  AdjustOptions options;
  options.max_rounds = 1;
  const AdjustReport report = Adjust(kFixed, {}, options, model);
  EXPECT_LT(report.rms_px, 0.6);
  EXPECT_LT(ErrorsAligned(CentersOf(model), CentersOf(scene.truth)).maxCoeff(), 0.03);
}

// Each image has some 2,500 observations.
TEST(Adjust, FindsTheSceneByAPartOfItsLandmarks) {
  Scene scene = MakeScene(0.0, Pinhole(), 10, 4000);
  std::erase_if(scene.truth.landmarks,
                [](const ReconLandmark& landmark) { return landmark.observations.size() < 2; });
  Reconstruction model = scene.truth;
  Perturb(0.01, 0.1, &scene, &model);
  AdjustOptions options;
  options.max_error_sigmas = 100.0;
  options.min_relative_change = 1e-12;
  options.max_observations_of_all = 1000;
  const AdjustReport report = Adjust(kFixed, {}, options, model);
  EXPECT_EQ(report.num_landmarks_removed, 0);
  EXPECT_LT(ErrorsAligned(CentersOf(model), CentersOf(scene.truth)).maxCoeff(), 1e-4);
  EXPECT_LT(ErrorsAligned(PointsOf(model), PointsOf(scene.truth)).maxCoeff(), 1e-3);
}

TEST(Adjust, IsTheSameOnAnyNumberOfThreads) {
  Scene scene = MakeScene(0.5, Pinhole());
  Reconstruction one = scene.truth;
  Perturb(0.01, 0.05, &scene, &one);
  Reconstruction four = one;
  AdjustOptions options;
  Adjust(kFocal, {}, options, one);
  options.num_threads = 4;
  Adjust(kFocal, {}, options, four);
  EXPECT_EQ(CentersOf(one), CentersOf(four));
  EXPECT_EQ(one.cameras[0].params(), four.cameras[0].params());
}

TEST(Adjust, LeavesAModelWithoutLandmarks) {
  Scene scene = MakeScene(0.2, Pinhole());
  Reconstruction model = scene.truth;
  model.landmarks.clear();
  const AdjustReport report = Adjust(kFocal, {}, {}, model);
  EXPECT_EQ(report.num_observations, 0);
  EXPECT_EQ(CentersOf(model), CentersOf(scene.truth));
}

TEST(Adjust, HoldsTheGaugeWithoutObservationsInTheFirstImage) {
  Scene scene = MakeScene(0.2, Pinhole());
  Reconstruction model = scene.truth;
  for (ReconLandmark& landmark : model.landmarks) {
    std::erase_if(landmark.observations,
                  [](const ReconObservation& seen) { return seen.image_idx == 0; });
  }
  const AdjustReport report = Adjust(kFixed, {}, {}, model);
  EXPECT_GT(report.num_observations, 0);
  EXPECT_EQ(CentersOf(model).col(0), CentersOf(scene.truth).col(0));
}

TEST(AdjustOptions, RefuseWhatMakesNoSense) {
  AdjustOptions options;
  options.max_error_sigmas = 0.0;
  EXPECT_THROW(options.Validate(), Error);
}

// Image name -> center by the laser scan.
std::map<std::string, Eigen::Vector3d> ReadTruth(const std::string& folder,
                                                 const std::string& prefix) {
  std::map<std::string, Eigen::Vector3d> truth;
  const std::string text = ReadTextFile(
      (testing::TestDataDir() / "facades_strecha" / folder / "truth.csv").string(), 1 << 20);
  CsvReader reader(text);
  while (reader.Next()) {
    if (reader.cells().size() == 11 && reader.Number(8)) {
      truth[prefix + reader.cells()[0]] = {*reader.Number(8), *reader.Number(9),
                                           *reader.Number(10)};
    }
  }
  return truth;
}

Eigen::VectorXd LaserErrors(const Reconstruction& model,
                            const std::map<std::string, Eigen::Vector3d>& truth) {
  Centers expected(3, model.images.size());
  for (size_t i = 0; i < model.images.size(); ++i) {
    expected.col(i) = truth.at(model.images[i].name);
  }
  return ErrorsAligned(CentersOf(model), expected);
}

Reconstruction ReadFacade(const std::string& folder) {
  const auto path = testing::TestDataDir() / "facades_strecha" / folder;
  return ReadColmap({path.string(), (path / "database.db").string(), {}});
}

// COLMAP's own result has 2.4 mm in the mean.
TEST(Adjust, IsNearTheLaserScanOfTheFountain) {
  CAIRN_SKIP_WITHOUT_DATA("facades_strecha/colmap_fountain-P11/images.bin");
  Reconstruction model = ReadFacade("colmap_fountain-P11");
  Scene noise;
  Perturb(0.003, 0.02, &noise, &model);
  const auto truth = ReadTruth("fountain-P11", "");
  EXPECT_GT(LaserErrors(model, truth).mean(), 0.01);
  AdjustOptions options;
  options.max_rounds = 1;
  const AdjustReport report = Adjust(kFixed, {}, options, model);
  const Eigen::VectorXd errors = LaserErrors(model, truth);
  EXPECT_LT(errors.mean(), 0.0026);
  EXPECT_LT(errors.maxCoeff(), 0.004);
  EXPECT_LT(report.rms_px, 0.6);
}

// Half a thousand keypoints a photo tell its pose nearly as well as all.
TEST(Adjust, IsNearTheLaserScanByAPartOfTheLandmarks) {
  CAIRN_SKIP_WITHOUT_DATA("facades_strecha/colmap_fountain-P11/images.bin");
  Reconstruction model = ReadFacade("colmap_fountain-P11");
  Scene noise;
  Perturb(0.003, 0.02, &noise, &model);
  AdjustOptions options;
  options.max_rounds = 1;
  options.max_observations_of_all = 0;
  Adjust(kFixed, {}, options, model);
  const Eigen::VectorXd errors = LaserErrors(model, ReadTruth("fountain-P11", ""));
  EXPECT_LT(errors.mean(), 0.003);
  EXPECT_LT(errors.maxCoeff(), 0.005);
}

}  // namespace
}  // namespace cairn
