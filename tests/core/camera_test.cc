#include "core/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/angles.h"
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
      Camera(CameraModel::kFullOpenCv, 640, 480,
             {500, 510, 321, 242, 0.3, -0.1, 1e-3, -2e-3, 0.02, 0.35, 0.02, -0.01}),
      Camera(CameraModel::kFov, 640, 480, {400, 410, 320, 240, 0.9}),
      Camera(CameraModel::kSimpleRadialFisheye, 640, 480, {300, 320, 240, 0.03}),
      Camera(CameraModel::kRadialFisheye, 640, 480, {300, 320, 240, 0.03, -0.01}),
      Camera(CameraModel::kThinPrismFisheye, 640, 480,
             {300, 301, 320, 240, 0.03, -0.01, 1e-3, -2e-3, 2e-3, -1e-4, 3e-3, -4e-3}),
      Camera(CameraModel::kRadTanThinPrismFisheye, 640, 480,
             {300, 301, 320, 240, 0.03, -0.01, 4e-3, -2e-3, 3e-4, -2e-5, 1e-3, -2e-3, 3e-3, -1e-3,
              -4e-3, 5e-4}),
  };
}

// COLMAP's documentation of its models, written out once more and without any of our code: the
// pixel of a point at (u, v, 1).
Eigen::Vector2d ByTheFormula(const Camera& camera, double u, double v) {
  const std::vector<double>& p = camera.params();
  const double r = std::hypot(u, v), theta = std::atan(r);
  const double a = theta * u / r, b = theta * v / r;
  switch (camera.model()) {
    case CameraModel::kFullOpenCv: {
      const double r2 = r * r, r4 = r2 * r2, r6 = r4 * r2;
      const double radial =
          (1 + p[4] * r2 + p[5] * r4 + p[8] * r6) / (1 + p[9] * r2 + p[10] * r4 + p[11] * r6);
      return {p[0] * (u * radial + 2 * p[6] * u * v + p[7] * (r2 + 2 * u * u)) + p[2],
              p[1] * (v * radial + 2 * p[7] * u * v + p[6] * (r2 + 2 * v * v)) + p[3]};
    }
    case CameraModel::kFov: {
      const double bent = std::atan(2 * r * std::tan(p[4] / 2)) / p[4];
      return {p[0] * u / r * bent + p[2], p[1] * v / r * bent + p[3]};
    }
    case CameraModel::kSimpleRadialFisheye: {
      const double bent = 1 + p[3] * theta * theta;
      return {p[0] * a * bent + p[1], p[0] * b * bent + p[2]};
    }
    case CameraModel::kRadialFisheye: {
      const double bent = 1 + p[3] * std::pow(theta, 2) + p[4] * std::pow(theta, 4);
      return {p[0] * a * bent + p[1], p[0] * b * bent + p[2]};
    }
    case CameraModel::kThinPrismFisheye: {
      const double t2 = theta * theta;
      const double radial =
          p[4] * t2 + p[5] * t2 * t2 + p[8] * std::pow(theta, 6) + p[9] * std::pow(theta, 8);
      const double da = a * radial + 2 * p[6] * a * b + p[7] * (t2 + 2 * a * a) + p[10] * t2;
      const double db = b * radial + 2 * p[7] * a * b + p[6] * (t2 + 2 * b * b) + p[11] * t2;
      return {p[0] * (a + da) + p[2], p[1] * (b + db) + p[3]};
    }
    case CameraModel::kRadTanThinPrismFisheye: {
      const double t2 = theta * theta;
      double radial = 1.0;
      for (int i = 0; i < 6; ++i) {
        radial += p[4 + i] * std::pow(t2, i + 1);
      }
      const double x = a * radial, y = b * radial, r2 = x * x + y * y;
      const double dx = 2 * p[11] * x * y + p[10] * (r2 + 2 * x * x) + p[12] * r2 + p[13] * r2 * r2;
      const double dy = 2 * p[10] * x * y + p[11] * (r2 + 2 * y * y) + p[14] * r2 + p[15] * r2 * r2;
      return {p[0] * (x + dx) + p[2], p[1] * (y + dy) + p[3]};
    }
    default:
      return *camera.Project({u, v, 1.0});  // Tested by hand below, and older than this function.
  }
}

TEST(Camera, ProjectsByColmapsFormulae) {
  for (const Camera& camera : AllModels()) {
    for (const Eigen::Vector2d& point :
         {Eigen::Vector2d(0.2, -0.1), Eigen::Vector2d(-0.5, 0.4), Eigen::Vector2d(0.01, 0.3)}) {
      const auto pixel = camera.Project({3.0 * point.x(), 3.0 * point.y(), 3.0});
      ASSERT_TRUE(pixel) << CameraModelName(camera.model());
      EXPECT_LT((*pixel - ByTheFormula(camera, point.x(), point.y())).norm(), 1e-9)
          << CameraModelName(camera.model());
    }
  }
}

// With coefficients that switch a part off, a model is another one.
TEST(Camera, ModelsAgreeWhereOneContainsTheOther) {
  const auto expect_same = [](const Camera& a, const Camera& b) {
    for (const Eigen::Vector3d& x_in_cam :
         {Eigen::Vector3d(0.3, -0.2, 1.0), Eigen::Vector3d(-0.8, 0.6, 1.0)}) {
      EXPECT_LT((*a.Project(x_in_cam) - *b.Project(x_in_cam)).norm(), 1e-9);
    }
  };
  expect_same(
      Camera(CameraModel::kFullOpenCv, 640, 480,
             {500, 510, 321, 242, -0.1, 0.02, 1e-3, -2e-3, 0, 0, 0, 0}),
      Camera(CameraModel::kOpenCv, 640, 480, {500, 510, 321, 242, -0.1, 0.02, 1e-3, -2e-3}));
  expect_same(Camera(CameraModel::kThinPrismFisheye, 640, 480,
                     {300, 301, 320, 240, 0.03, -0.01, 0, 0, 2e-3, -1e-4, 0, 0}),
              Camera(CameraModel::kOpenCvFisheye, 640, 480,
                     {300, 301, 320, 240, 0.03, -0.01, 2e-3, -1e-4}));
  expect_same(Camera(CameraModel::kRadTanThinPrismFisheye, 640, 480,
                     {300, 301, 320, 240, 0.03, -0.01, 2e-3, -1e-4, 0, 0, 0, 0, 0, 0, 0, 0}),
              Camera(CameraModel::kOpenCvFisheye, 640, 480,
                     {300, 301, 320, 240, 0.03, -0.01, 2e-3, -1e-4}));
  expect_same(Camera(CameraModel::kFov, 640, 480, {500, 510, 320, 240, 2e-6}),
              Camera(CameraModel::kFov, 640, 480, {500, 510, 320, 240, 0.0}));
  expect_same(Camera(CameraModel::kFov, 640, 480, {500, 510, 320, 240, 0.0}),
              Camera(CameraModel::kPinhole, 640, 480, {500, 510, 320, 240}));
}

// What bends a fisheye's image stays invertible up to where the picture ends, 80 degrees off axis.
TEST(Camera, FisheyesReachTheEdgeOfTheirField) {
  for (const Camera& camera : AllModels()) {
    if (!IsFisheye(camera.model()) || camera.model() == CameraModel::kFov) {
      continue;
    }
    const double radius = std::tan(80.0 / kDegPerRad);
    const Eigen::Vector3d ray = Eigen::Vector3d(0.6 * radius, 0.8 * radius, 1.0).normalized();
    const auto pixel = camera.Project(ray);
    ASSERT_TRUE(pixel) << CameraModelName(camera.model());
    const auto back = camera.Unproject(*pixel);
    ASSERT_TRUE(back) << CameraModelName(camera.model());
    EXPECT_LT((*back - ray).norm(), 1e-8);
  }
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
  // (1, 0, 2): normalized (0.5, 0), r^2 = 0.25, factor 1.125.
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
  for (const Camera& camera : AllModels()) {
    const CameraModel model = camera.model();
    EXPECT_EQ(CameraModelFromName(CameraModelName(model)), model);
    EXPECT_EQ(CameraModelFromColmapId(static_cast<int>(model)), model);
  }
}

TEST(Camera, ModelsOfColmapThatAreNotKnownAreRefusedByName) {
  const auto message_of = [](const auto& look_up) -> std::string {
    try {
      look_up();
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  const std::string by_name = message_of([] { CameraModelFromName("SIMPLE_DIVISION"); });
  EXPECT_NE(by_name.find("'SIMPLE_DIVISION'"), std::string::npos);
  EXPECT_NE(by_name.find("RAD_TAN_THIN_PRISM_FISHEYE"), std::string::npos);
  const std::string by_id = message_of([] { CameraModelFromColmapId(12); });
  EXPECT_NE(by_id.find("SIMPLE_DIVISION"), std::string::npos);
  EXPECT_NE(message_of([] { CameraModelFromColmapId(17); }).find("EQUIRECTANGULAR"),
            std::string::npos);
  EXPECT_NE(message_of([] { CameraModelFromColmapId(-1); }).find("-1"), std::string::npos);
  EXPECT_NE(message_of([] { CameraModelFromColmapId(2'000'000'000); }).find("2000000000"),
            std::string::npos);
  EXPECT_LT(message_of([] { CameraModelFromName(std::string(100'000, 'x')); }).size(), 400u);
}

TEST(Camera, RefusesNonsense) {
  EXPECT_THROW(Camera(CameraModel::kPinhole, 640, 480, {500, 320, 240}), Error);
  EXPECT_THROW(Camera(CameraModel::kPinhole, 0, 480, {500, 500, 320, 240}), Error);
  EXPECT_THROW(Camera(CameraModel::kPinhole, 640, 480, {-1, 500, 320, 240}), Error);
  EXPECT_THROW(Camera(CameraModel::kSimplePinhole, 640, 480,
                      {500, std::numeric_limits<double>::quiet_NaN(), 240}),
               Error);
  EXPECT_THROW(Camera(CameraModel::kFov, 640, 480, {500, 500, 320, 240, 3.2}), Error);
}

}  // namespace
}  // namespace cairn
