#include "core/focal_length.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "support/cameras.h"

namespace cairn {
namespace {

TEST(WithFocalScaled, MovesPixelsAwayFromThePrincipalPoint) {
  const Eigen::Vector3d x_in_cam(0.3, -0.2, 1.0);
  for (const Camera& camera : testing::OneCameraPerModel()) {
    const Camera scaled = WithFocalScaled(camera, 1.2);
    const Eigen::Vector2d center = PrincipalPointPx(camera);
    EXPECT_EQ(PrincipalPointPx(scaled), center);
    EXPECT_NEAR(scaled.focal_px(), 1.2 * camera.focal_px(), 1e-9);
    EXPECT_NEAR(
        (*scaled.Project(x_in_cam) - center - 1.2 * (*camera.Project(x_in_cam) - center)).norm(),
        0.0, 1e-9)
        << CameraModelName(camera.model());
  }
}

TEST(WithTwoFocalLengths, ProjectsAsBefore) {
  const Eigen::Vector3d x_in_cam(0.3, -0.2, 1.0);
  for (const Camera& camera : testing::OneCameraPerModel()) {
    const bool has_two_of_kind =
        camera.model() <= CameraModel::kFullOpenCv && camera.model() != CameraModel::kOpenCvFisheye;
    EXPECT_TRUE(!has_two_of_kind || NumFocalLengths(WithTwoFocalLengths(camera).model()) == 2);
    EXPECT_LT((*WithTwoFocalLengths(camera).Project(x_in_cam) - *camera.Project(x_in_cam)).norm(),
              1e-9)
        << CameraModelName(camera.model());
  }
}

TEST(CameraOfUnknownFocal, LooksStraightThroughTheMiddle) {
  const Camera camera = CameraOfUnknownFocal(600, 1000);
  EXPECT_EQ(camera.model(), CameraModel::kSimpleRadial);
  EXPECT_EQ(camera.focal_px(), 850.0);
  EXPECT_EQ(PrincipalPointPx(camera), Eigen::Vector2d(300.0, 500.0));
  EXPECT_EQ(*camera.Project({0.1, 0.0, 1.0}), Eigen::Vector2d(385.0, 500.0));
}

TEST(FocalPrior, RefusesWhatMakesNoSense) {
  for (const double log_sigma : {0.0, -0.1, 0.6, std::nan("")}) {
    EXPECT_THROW(FocalPrior{.log_sigma = log_sigma}.Validate(Camera()), Error) << log_sigma;
  }
  EXPECT_THROW(FocalPrior{.with_distortion = true}.Validate(Camera()), Error);
  EXPECT_NO_THROW(FocalPrior{.with_distortion = true}.Validate(CameraOfUnknownFocal(4, 3)));
}

}  // namespace
}  // namespace cairn
