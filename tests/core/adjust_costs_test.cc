#include "core/adjust/adjust_costs.h"

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <vector>

#include "core/adjust/adjustable_camera.h"
#include "support/numeric_jacobian.h"

namespace cairn {
namespace {

using Pose = std::array<double, kPoseSize>;

Pose SomePose() {
  Pose pose;
  StorePose({Eigen::Quaterniond(0.9, 0.1, -0.3, 0.2), Eigen::Vector3d(0.3, -0.2, 4.0)},
            pose.data());
  return pose;
}

std::vector<Camera> Cameras() {
  return {{CameraModel::kSimplePinhole, 640, 480, {500.0, 320.0, 240.0}},
          {CameraModel::kPinhole, 640, 480, {500.0, 510.0, 320.0, 240.0}},
          {CameraModel::kSimpleRadial, 640, 480, {500.0, 320.0, 240.0, -0.1}},
          {CameraModel::kRadial, 640, 480, {500.0, 320.0, 240.0, -0.1, 0.02}},
          {CameraModel::kOpenCv, 640, 480, {500.0, 510.0, 320.0, 240.0, -0.1, 0.02, 0.003, -0.002}},
          {CameraModel::kOpenCvFisheye,
           640,
           480,
           {500.0, 510.0, 320.0, 240.0, -0.1, 0.02, 0.003, -0.002}}};
}

const Eigen::Vector3d kPoint(1.1, 0.4, 1.3);

CameraUnknowns Unknowns(double log_focal_ratio, double k1, double k2, double x_px, double y_px) {
  return (CameraUnknowns() << log_focal_ratio, k1, k2, x_px, y_px).finished();
}

// The residual after the pose moved along the manifold by the last six of `delta`, the point by the
// first three, the camera by the five in between.
Eigen::Vector2d Residual(const ReprojectionCost& cost, const CameraUnknowns& unknowns,
                         const Eigen::Matrix<double, 14, 1>& delta) {
  const Eigen::Vector3d point = kPoint + delta.head<3>();
  const CameraUnknowns camera = unknowns + delta.segment<kCameraSize>(3);
  const Pose pose = SomePose();
  Pose moved;
  const Eigen::Matrix<double, 6, 1> motion = delta.tail<6>();
  PoseManifold().Plus(pose.data(), motion.data(), moved.data());
  const double* parameters[] = {point.data(), moved.data(), camera.data()};
  Eigen::Vector2d residual;
  EXPECT_TRUE(cost.Evaluate(parameters, residual.data(), nullptr));
  return residual;
}

TEST(ReprojectionCost, HasTheDerivativesOfNumericDifferentiation) {
  for (const Camera& camera : Cameras()) {
    SCOPED_TRACE(CameraModelName(camera.model()));
    const AdjustableCamera adjustable(camera);
    const CameraUnknowns unknowns = adjustable.start() + Unknowns(0.05, 0.01, -0.02, 7.0, -5.0);
    const ReprojectionCost cost(&adjustable, {300.0, 200.0}, 0.7);
    const Pose pose = SomePose();
    const double* parameters[] = {kPoint.data(), pose.data(), unknowns.data()};
    Eigen::Vector2d residual;
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> by_point;
    Eigen::Matrix<double, 2, kCameraSize, Eigen::RowMajor> by_camera;
    Eigen::Matrix<double, 2, 7, Eigen::RowMajor> by_pose;
    double* jacobians[] = {by_point.data(), by_pose.data(), by_camera.data()};
    ASSERT_TRUE(cost.Evaluate(parameters, residual.data(), jacobians));
    Eigen::Matrix<double, 2, 14> analytic;
    analytic << by_point, by_camera, by_pose.leftCols<6>();
    const auto numeric = testing::NumericJacobian<2, 14>(
        [&](const auto& delta) { return Residual(cost, unknowns, delta); });
    EXPECT_LT((analytic - numeric).norm(), 1e-6 * numeric.norm());
    EXPECT_TRUE(by_pose.col(6).isZero());
  }
}

TEST(ReprojectionCost, RefusesAPointBehindTheCamera) {
  const AdjustableCamera camera(Cameras()[1]);
  const ReprojectionCost cost(&camera, {300.0, 200.0}, 1.0);
  const Pose pose = SomePose();
  const Eigen::Vector3d center = Eigen::Map<const Eigen::Vector3d>(pose.data() + 4);
  const Eigen::Vector3d behind = 2.0 * center - kPoint;
  const double* parameters[] = {behind.data(), pose.data(), camera.start().data()};
  Eigen::Vector2d residual;
  EXPECT_FALSE(cost.Evaluate(parameters, residual.data(), nullptr));
}

TEST(PositionCost, HasTheDerivativesOfNumericDifferentiation) {
  const PositionCost cost({1.0, 2.0, 3.0}, {0.5, 2.0, 4.0});
  const Pose pose = SomePose();
  const double* parameters[] = {pose.data()};
  Eigen::Vector3d residual;
  Eigen::Matrix<double, 3, 7, Eigen::RowMajor> by_pose;
  double* jacobians[] = {by_pose.data()};
  ASSERT_TRUE(cost.Evaluate(parameters, residual.data(), jacobians));
  const auto numeric =
      testing::NumericJacobian<3, 6>([&](const Eigen::Matrix<double, 6, 1>& delta) {
        Pose moved;
        PoseManifold().Plus(pose.data(), delta.data(), moved.data());
        const double* at[] = {moved.data()};
        Eigen::Vector3d value;
        cost.Evaluate(at, value.data(), nullptr);
        return value;
      });
  EXPECT_LT((by_pose.leftCols<6>() - numeric).norm(), 1e-8);
}

TEST(PoseManifold, MinusUndoesPlus) {
  const Pose pose = SomePose();
  Eigen::Matrix<double, 6, 1> delta;
  delta << 0.1, -0.2, 0.3, 1.0, 2.0, -3.0;
  Pose moved;
  PoseManifold().Plus(pose.data(), delta.data(), moved.data());
  Eigen::Matrix<double, 6, 1> found;
  PoseManifold().Minus(moved.data(), pose.data(), found.data());
  EXPECT_LT((found - delta).norm(), 1e-12);
}

TEST(PoseOnPlaneManifold, HoldsACoordinateOfTheCenter) {
  const Pose pose = SomePose();
  const Eigen::Matrix<double, 5, 1> delta = Eigen::Matrix<double, 5, 1>::Constant(0.3);
  Pose moved;
  PoseOnPlaneManifold(1).Plus(pose.data(), delta.data(), moved.data());
  EXPECT_EQ(moved[5], pose[5]);
  EXPECT_NE(moved[4], pose[4]);
  EXPECT_NE(moved[6], pose[6]);
}

TEST(AdjustableCamera, ProjectsAsTheCameraThatItBecomes) {
  for (const Camera& camera : Cameras()) {
    SCOPED_TRACE(CameraModelName(camera.model()));
    const AdjustableCamera adjustable(camera);
    CameraUnknowns unknowns = adjustable.start() + Unknowns(0.05, 0.0, 0.0, 7.0, -5.0);
    if (adjustable.has_free_distortion()) {
      unknowns.segment<2>(1) += Eigen::Vector2d(0.01, -0.02);
    }
    Eigen::Vector2d pixel;
    ASSERT_TRUE(adjustable.Project(unknowns, {0.3, -0.2, 1.0}, &pixel, nullptr, nullptr));
    const auto expected = adjustable.With(unknowns).Project({0.3, -0.2, 1.0});
    ASSERT_TRUE(expected);
    EXPECT_LT((pixel - *expected).norm(), 1e-9);
  }
}

TEST(AdjustableCamera, KeepsItsModelWithoutDistortion) {
  const AdjustableCamera adjustable(Cameras()[1]);
  EXPECT_EQ(adjustable.With(Unknowns(0.1, 0.0, 0.0, 3.0, 2.0)).model(), CameraModel::kPinhole);
  EXPECT_EQ(adjustable.With(Unknowns(0.1, 0.1, 0.0, 3.0, 2.0)).model(), CameraModel::kOpenCv);
}

}  // namespace
}  // namespace cairn
