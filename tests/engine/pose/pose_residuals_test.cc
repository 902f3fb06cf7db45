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

TEST(ReprojectionResidual, JacobianAgreesWithFiniteDifferencesForEveryCameraModel) {
  for (const Camera& camera : testing::OneCameraPerModel()) {
    for (const Vector3d& x_in_cam :
         {Vector3d(0.5, -0.8, 6.0), Vector3d(-3.0, 2.0, 9.0), Vector3d(0.0, 0.0, 2.0)}) {
      const Vector3d x_in_anchor = kAnchorFromCam * x_in_cam;
      const Vector2d pixel(100.0, 200.0);
      Eigen::Matrix<double, 2, 6> jacobian;
      const auto residual =
          ReprojectionResidual(camera, pixel, x_in_anchor, kAnchorFromCam, &jacobian);
      ASSERT_TRUE(residual);
      const auto numeric = NumericJacobian<2, 6>([&](const PoseTangent& delta) -> Vector2d {
        return *ReprojectionResidual(camera, pixel, x_in_anchor, PerturbPose(kAnchorFromCam, delta),
                                     nullptr);
      });
      EXPECT_LT((jacobian - numeric).norm(), 1e-5 * numeric.norm())
          << CameraModelName(camera.model());
    }
  }
}

TEST(ReprojectionResidual, IsProjectionMinusPixelWithOrWithoutJacobian) {
  const Camera camera;
  const Vector3d x_in_cam(1.0, 2.0, 10.0);
  const Vector2d pixel(300.0, 310.0);
  Eigen::Matrix<double, 2, 6> jacobian;
  const Vector2d expected = *camera.Project(x_in_cam) - pixel;
  const Vector3d x_in_anchor = kAnchorFromCam * x_in_cam;
  EXPECT_LT((*ReprojectionResidual(camera, pixel, x_in_anchor, kAnchorFromCam, nullptr) - expected)
                .norm(),
            1e-9);
  EXPECT_LT(
      (*ReprojectionResidual(camera, pixel, x_in_anchor, kAnchorFromCam, &jacobian) - expected)
          .norm(),
      1e-9);
}

TEST(ReprojectionResidual, NothingBehindTheCamera) {
  const Vector3d x_in_anchor = kAnchorFromCam * Vector3d(0.1, 0.2, -5.0);
  Eigen::Matrix<double, 2, 6> jacobian;
  EXPECT_FALSE(ReprojectionResidual(Camera(), {0, 0}, x_in_anchor, kAnchorFromCam, nullptr));
  EXPECT_FALSE(ReprojectionResidual(Camera(), {0, 0}, x_in_anchor, kAnchorFromCam, &jacobian));
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

}  // namespace
}  // namespace cairn
