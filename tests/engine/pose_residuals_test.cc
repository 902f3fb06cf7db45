#include "engine/pose/pose_residuals.h"

#include <gtest/gtest.h>

#include "support/cameras.h"
#include "support/numeric_jacobian.h"

namespace cairn {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::NumericJacobian;

const Rigid3d kAnchorFromCam(ExpSo3({0.5, -1.2, 0.8}), Vector3d(12.0, -7.0, 3.0));

TEST(ProjectLandmark, GivesThePixelAndItsDerivativeForEveryCameraModel) {
  for (const Camera& camera : testing::OneCameraPerModel()) {
    const PosedCamera posed(camera, kAnchorFromCam);
    for (const Vector3d& x_in_cam :
         {Vector3d(0.5, -0.8, 6.0), Vector3d(-3.0, 2.0, 9.0), Vector3d(0.0, 0.0, 2.0)}) {
      const Vector3d x_in_anchor = kAnchorFromCam * x_in_cam;
      Eigen::Matrix<double, 2, 3> derivative, unused;
      const auto pixel = ProjectLandmark(posed, x_in_anchor, &derivative);
      ASSERT_TRUE(pixel);
      EXPECT_LT((*pixel - *camera.Project(x_in_cam)).norm(), 1e-9);
      const auto numeric = NumericJacobian<2, 3>([&](const Vector3d& delta) -> Vector2d {
        return *ProjectLandmark(posed, x_in_anchor + delta, &unused);
      });
      EXPECT_LT((derivative - numeric).norm(), 1e-5 * numeric.norm())
          << CameraModelName(camera.model());
    }
  }
}

TEST(ProjectLandmark, NothingBehindTheCamera) {
  const Camera camera;
  Eigen::Matrix<double, 2, 3> derivative;
  EXPECT_FALSE(ProjectLandmark(PosedCamera(camera, kAnchorFromCam),
                               kAnchorFromCam * Vector3d(0.1, 0.2, -5.0), &derivative));
}

// Of a camera at the center of the rig, and of one that stands elsewhere and looks elsewhere.
TEST(ReprojectionJacobian, AgreesWithFiniteDifferencesForEveryCameraModel) {
  for (const Camera& camera : testing::OneCameraPerModel()) {
    for (const Rigid3d& own_from_cam :
         {Rigid3d(), Rigid3d(ExpSo3({0.2, 0.5, -0.1}), Vector3d(0.8, -0.3, 0.4))}) {
      const Vector3d x_in_anchor =
          kAnchorFromCam * own_from_cam.Inverse() * Vector3d(0.5, -0.8, 6.0);
      const auto project = [&](const Rigid3d& anchor_from_cam,
                               Eigen::Matrix<double, 2, 3>* derivative) {
        const PosedCamera own(camera, anchor_from_cam * own_from_cam.Inverse());
        return *ProjectLandmark(own, x_in_anchor, derivative);
      };
      Eigen::Matrix<double, 2, 3> derivative, unused;
      project(kAnchorFromCam, &derivative);
      const auto jacobian =
          ReprojectionJacobian(derivative, x_in_anchor - kAnchorFromCam.translation);
      const auto numeric = NumericJacobian<2, 6>([&](const PoseTangent& delta) -> Vector2d {
        return project(PerturbPose(kAnchorFromCam, delta), &unused);
      });
      EXPECT_LT((jacobian - numeric).norm(), 1e-5 * numeric.norm())
          << CameraModelName(camera.model());
    }
  }
}

TEST(GravityResidual, JacobianAgreesWithFiniteDifferences) {
  const Vector3d down_in_cam = Vector3d(0.1, 0.95, -0.2).normalized();
  Eigen::Matrix<double, 3, 6> jacobian;
  GravityResidual(down_in_cam, kAnchorFromCam, &jacobian);
  const auto numeric = NumericJacobian<3, 6>([&](const PoseTangent& delta) -> Vector3d {
    return GravityResidual(down_in_cam, PerturbPose(kAnchorFromCam, delta), nullptr);
  });
  EXPECT_LT((jacobian - numeric).norm(), 1e-8);
}

TEST(GravityResidual, NormIsAngleForSmallErrors) {
  const Vector3d down_in_cam = kAnchorFromCam.rotation.conjugate() * -Vector3d::UnitZ();
  EXPECT_LT(GravityResidual(down_in_cam, kAnchorFromCam, nullptr).norm(), 1e-12);
  const Vector3d axis = down_in_cam.unitOrthogonal();
  const Vector3d tilted = ExpSo3(0.01 * axis) * down_in_cam;
  EXPECT_NEAR(GravityResidual(tilted, kAnchorFromCam, nullptr).norm(), 0.01, 1e-6);
}

TEST(PerturbPose, StandsOnTheLeft) {
  PoseTangent tangent;
  tangent << 0.0, 0.0, 0.1, 1.0, 2.0, 3.0;
  const Rigid3d moved = PerturbPose(kAnchorFromCam, tangent);
  EXPECT_LT((moved.translation - (kAnchorFromCam.translation + Vector3d(1, 2, 3))).norm(), 1e-12);
  EXPECT_LT(RotationAngleRad(moved.rotation, ExpSo3({0, 0, 0.1}) * kAnchorFromCam.rotation), 1e-9);
}

TEST(ErrorShapeAt, MakesErrorsOfLandmarkAndKeypointRound) {
  Eigen::Matrix3d root;
  root << 0.3, 0.0, 0.1, 0.0, 0.05, 0.0, 0.2, 0.0, 0.4;
  const LandmarkShape landmark = {root * root.transpose(), {0.3, 0.0, 0.2}};
  constexpr double kSigmaPx = 0.7;
  for (const Camera& camera : testing::OneCameraPerModel()) {
    const PosedCamera posed(camera, kAnchorFromCam);
    const Vector3d x_in_anchor = kAnchorFromCam * Vector3d(0.5, -0.8, 6.0);
    Eigen::Matrix<double, 2, 3> pixel_by_anchor;
    ASSERT_TRUE(ProjectLandmark(posed, x_in_anchor, &pixel_by_anchor));
    const auto shape = ErrorShapeAt(posed, x_in_anchor, landmark, kSigmaPx);
    ASSERT_TRUE(shape);
    const Eigen::Matrix2d of_error =
        kSigmaPx * kSigmaPx * Eigen::Matrix2d::Identity() +
        pixel_by_anchor * landmark.covariance_sq_m * pixel_by_anchor.transpose();
    const Eigen::Matrix2d white = shape->whitening * of_error * shape->whitening.transpose();
    EXPECT_LT((white - kSigmaPx * kSigmaPx * Eigen::Matrix2d::Identity()).norm(), 1e-9);
    EXPECT_LT((shape->by_distance_px - shape->whitening * pixel_by_anchor * landmark.by_distance_m)
                  .norm(),
              1e-12);
  }
}

TEST(ErrorShapeAt, IsNothingBehindTheCamera) {
  EXPECT_FALSE(ErrorShapeAt(PosedCamera(Camera(), kAnchorFromCam),
                            kAnchorFromCam * Vector3d(0.1, 0.2, -5.0),
                            {Eigen::Matrix3d::Identity()}, 1.0));
}

}  // namespace
}  // namespace cairn
