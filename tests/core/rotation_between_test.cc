#include "core/rotation_between.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/angles.h"

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

}  // namespace
}  // namespace cairn
