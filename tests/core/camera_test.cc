#include "core/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/error.h"

namespace cairn {
namespace {

std::vector<Camera> AllModels() {
  return {
      Camera(CameraModel::kSimplePinhole, 640, 480, {500, 320, 240}),
      Camera(CameraModel::kPinhole, 640, 480, {500, 510, 320, 240}),
      Camera(CameraModel::kSimpleRadial, 640, 480, {500, 320, 240, -0.1}),
      Camera(CameraModel::kRadial, 640, 480, {500, 320, 240, -0.12, 0.03}),
      Camera(CameraModel::kOpenCv, 640, 480, {500, 510, 321, 242, -0.1, 0.02, 1e-3, -2e-3}),
      Camera(CameraModel::kOpenCvFisheye, 640, 480, {300, 301, 320, 240, 0.03, -0.01, 2e-3, -1e-4}),
  };
}

TEST(Camera, UnprojectInvertsProjectOverTheWholeImage) {
  for (const Camera& camera : AllModels()) {
    for (double y = 0.0; y <= 480.0; y += 48.0) {
      for (double x = 0.0; x <= 640.0; x += 64.0) {
        const auto ray = camera.Unproject({x, y});
        ASSERT_TRUE(ray) << CameraModelName(camera.model()) << " " << x << " " << y;
        EXPECT_NEAR(ray->norm(), 1.0, 1e-12);
        const auto pixel = camera.Project(7.0 * *ray);
        ASSERT_TRUE(pixel);
        EXPECT_NEAR(pixel->x(), x, 1e-8);
        EXPECT_NEAR(pixel->y(), y, 1e-8);
      }
    }
  }
}

TEST(Camera, ProjectsByHandComputedSimpleRadial) {
  const Camera camera(CameraModel::kSimpleRadial, 640, 480, {100, 320, 240, 0.5});
  // (1, 0, 2): normalised (0.5, 0), r^2 = 0.25, factor 1.125.
  const auto pixel = camera.Project({1.0, 0.0, 2.0});
  ASSERT_TRUE(pixel);
  EXPECT_DOUBLE_EQ(pixel->x(), 320.0 + 100.0 * 0.5 * 1.125);
  EXPECT_DOUBLE_EQ(pixel->y(), 240.0);
}

TEST(Camera, JacobianMatchesFiniteDifferences) {
  for (const Camera& camera : AllModels()) {
    for (const Eigen::Vector3d& x_in_cam :
         {Eigen::Vector3d(0.3, -0.2, 2.0), Eigen::Vector3d(-1.0, 0.7, 3.0),
          Eigen::Vector3d(0.0, 0.0, 1.0)}) {
      Eigen::Matrix<double, 2, 3> jacobian;
      ASSERT_TRUE(camera.ProjectWithJacobian(x_in_cam, &jacobian));
      for (int axis = 0; axis < 3; ++axis) {
        constexpr double kStep = 1e-6;
        const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(axis);
        const Eigen::Vector2d numeric =
            (*camera.Project(x_in_cam + step) - *camera.Project(x_in_cam - step)) / (2.0 * kStep);
        EXPECT_LT((numeric - jacobian.col(axis)).norm(), 1e-5 * (1.0 + numeric.norm()))
            << CameraModelName(camera.model()) << " axis " << axis;
      }
    }
  }
}

TEST(Camera, PointsBehindDoNotProject) {
  for (const Camera& camera : AllModels()) {
    EXPECT_FALSE(camera.Project({0.1, 0.1, -1.0}));
    EXPECT_FALSE(camera.Project({0.1, 0.1, 0.0}));
  }
}

TEST(Camera, PointsBeyondTheInvertibleRadiusDoNotProject) {
  // r (1 - 0.3 r^2) grows up to r = 1.054; a point at r = 2 would fold back into the image.
  const Camera camera(CameraModel::kSimpleRadial, 640, 480, {300, 320, 240, -0.3});
  EXPECT_TRUE(camera.Project({1.0, 0.0, 1.0}));
  EXPECT_FALSE(camera.Project({2.0, 0.0, 1.0}));
  EXPECT_FALSE(camera.Unproject({320.0 + 300.0 * 0.8, 240.0}));  // Beyond the largest image radius.
}

TEST(Camera, NamesAndIdsAreColmaps) {
  EXPECT_EQ(CameraModelFromName("OPENCV_FISHEYE"), CameraModel::kOpenCvFisheye);
  EXPECT_EQ(CameraModelFromColmapId(4), CameraModel::kOpenCv);
  EXPECT_THROW(CameraModelFromName("FULL_OPENCV"), Error);
  EXPECT_THROW(CameraModelFromColmapId(6), Error);
}

TEST(Camera, RefusesNonsense) {
  EXPECT_THROW(Camera(CameraModel::kPinhole, 640, 480, {500, 320, 240}), Error);
  EXPECT_THROW(Camera(CameraModel::kPinhole, 0, 480, {500, 500, 320, 240}), Error);
  EXPECT_THROW(Camera(CameraModel::kPinhole, 640, 480, {-1, 500, 320, 240}), Error);
  EXPECT_THROW(Camera(CameraModel::kSimplePinhole, 640, 480,
                      {500, std::numeric_limits<double>::quiet_NaN(), 240}),
               Error);
}

}  // namespace
}  // namespace cairn
