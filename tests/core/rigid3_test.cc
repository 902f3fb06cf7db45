#include "core/rigid3.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace cairn {
namespace {

const Rigid3d kAFromB(ExpSo3({0.3, -0.5, 0.9}), {1.0, 2.0, 3.0});
const Rigid3d kBFromC(ExpSo3({-1.0, 0.2, 0.4}), {-4.0, 0.5, 6.0});

TEST(Rigid3d, ComposesLikeItsPoints) {
  const Eigen::Vector3d x_in_c(0.7, -0.1, 2.0);
  EXPECT_LT((kAFromB * (kBFromC * x_in_c) - (kAFromB * kBFromC) * x_in_c).norm(), 1e-12);
}

TEST(Rigid3d, InverseUndoes) {
  const Eigen::Vector3d x_in_b(0.7, -0.1, 2.0);
  EXPECT_LT((kAFromB.Inverse() * (kAFromB * x_in_b) - x_in_b).norm(), 1e-12);
}

TEST(Sim3d, InverseUndoes) {
  const Sim3d a_from_b{2.5, ExpSo3({0.1, 0.2, -0.7}), {5.0, 6.0, -7.0}};
  const Eigen::Vector3d x_in_b(0.7, -0.1, 2.0);
  EXPECT_LT((a_from_b.Inverse() * (a_from_b * x_in_b) - x_in_b).norm(), 1e-12);
}

TEST(Sim3d, ProductsApplyTheRightOneFirst) {
  const Sim3d a_from_b{2.5, ExpSo3({0.1, 0.2, -0.7}), {5.0, 6.0, -7.0}};
  const Sim3d b_from_c{0.3, ExpSo3({-1.1, 0.4, 0.2}), {-2.0, 0.5, 9.0}};
  const Eigen::Vector3d x_in_c(0.7, -0.1, 2.0);
  EXPECT_LT((a_from_b * b_from_c * x_in_c - a_from_b * (b_from_c * x_in_c)).norm(), 1e-12);
}

TEST(Sim3d, CamFromTargetSeesPointsInTheSameDirection) {
  const Sim3d target_from_world{3.0, ExpSo3({0.1, 0.2, -0.7}), {5.0, 6.0, -7.0}};
  const Eigen::Vector3d x_in_world(1.0, 2.0, 9.0);
  const Eigen::Vector3d x_in_cam = kAFromB * x_in_world;
  const Eigen::Vector3d x_in_metric_cam =
      CamFromTarget(kAFromB, target_from_world) * (target_from_world * x_in_world);
  EXPECT_LT((x_in_metric_cam - 3.0 * x_in_cam).norm(), 1e-12);
}

TEST(So3, LogInvertsExp) {
  for (const Eigen::Vector3d& vector :
       {Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(1e-9, 0.0, 0.0),
        Eigen::Vector3d(0.4, -1.2, 2.0), Eigen::Vector3d(0.0, 3.1415, 0.0)}) {
    EXPECT_LT((LogSo3(ExpSo3(vector)) - vector).norm(), 1e-12);
  }
}

TEST(So3, LogTakesTheShorterWay) {
  const Eigen::Quaterniond rotation = ExpSo3({0.0, 0.0, 0.5});
  const Eigen::Quaterniond same(-rotation.w(), -rotation.x(), -rotation.y(), -rotation.z());
  EXPECT_LT((LogSo3(same) - Eigen::Vector3d(0.0, 0.0, 0.5)).norm(), 1e-12);
  EXPECT_NEAR(RotationAngleRad(same, Eigen::Quaterniond::Identity()), 0.5, 1e-12);
}

TEST(So3, SkewIsTheCrossProduct) {
  const Eigen::Vector3d a(1.0, 2.0, 3.0), b(-2.0, 0.5, 4.0);
  EXPECT_EQ(Skew(a) * b, a.cross(b));
}

}  // namespace
}  // namespace cairn
