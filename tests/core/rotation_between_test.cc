#include "core/rotation_between.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/angles.h"
#include "core/rigid3.h"

namespace cairn {
namespace {

TEST(RotationBetween, TurnsOneDirectionToTheOther) {
  const Eigen::Vector3d from(1.0, -2.0, 0.5);
  const Eigen::Vector3d to(0.3, 4.0, -1.0);
  const Eigen::Quaterniond rotation = RotationBetween(from, to);
  EXPECT_LT((rotation * from.normalized() - to.normalized()).norm(), 1e-12);
  EXPECT_NEAR(Eigen::AngleAxisd(rotation).angle(),
              std::acos(from.normalized().dot(to.normalized())), 1e-12);
}

TEST(RotationBetween, OppositeDirectionsAreAHalfTurnApart) {
  const Eigen::Vector3d from(0.0, 0.0, 2.0);
  const Eigen::Quaterniond rotation = RotationBetween(from, -from);
  EXPECT_LT((rotation * from + from).norm(), 1e-9);
  EXPECT_NEAR(Eigen::AngleAxisd(rotation).angle(), kPi, 1e-6);
}

TEST(AngleBetween, IsExactForSmallAndLargeAngles) {
  const Eigen::Vector3d x(3.0, 0.0, 0.0);
  EXPECT_EQ(AngleBetweenRad(x, {5.0, 0.0, 0.0}), 0.0);
  EXPECT_DOUBLE_EQ(AngleBetweenRad(x, {1.0, 1e-9, 0.0}), 1e-9);
  EXPECT_DOUBLE_EQ(AngleBetweenRad(x, {0.0, 0.0, 2.0}), kPi / 2.0);
  EXPECT_DOUBLE_EQ(AngleBetweenRad(x, {-1.0, 1e-3, 0.0}), kPi - std::atan(1e-3));
}

TEST(Yaw, IsTheAngleAboutZ) {
  EXPECT_DOUBLE_EQ(YawRad(ExpSo3({0.0, 0.0, 2.5})), 2.5);
  EXPECT_NEAR(YawRad(ExpSo3({0.0, 0.0, 4.0})), 4.0 - 2.0 * kPi, 1e-12);
  // Of the product of a yaw and a tilt, the yaw.
  EXPECT_NEAR(YawRad(ExpSo3({0.0, 0.0, -1.5}) * ExpSo3({0.3, -0.2, 0.0})), -1.5, 1e-12);
}

}  // namespace
}  // namespace cairn
