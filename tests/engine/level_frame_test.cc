#include "engine/query/level_frame.h"

#include <gtest/gtest.h>

namespace cairn {
namespace {

using Eigen::Vector3d;

TEST(LevelFromCam, TurnsDownToMinusZAndKeepsViewingDirectionAhead) {
  for (int i = 0; i < 100; ++i) {
    const Vector3d down_in_cam = Vector3d::Random().normalized();
    const Eigen::Quaterniond level_from_cam = LevelFromCam(down_in_cam);
    EXPECT_TRUE((level_from_cam * down_in_cam).isApprox(-Vector3d::UnitZ(), 1e-12));
    const Vector3d forward_in_level = level_from_cam * Vector3d::UnitZ();
    EXPECT_NEAR(forward_in_level.y(), 0.0, 1e-12);
    EXPECT_GT(forward_in_level.x(), 0.0);
  }
}

TEST(LevelFromCam, UprightCameraLooksAlongX) {
  const Eigen::Quaterniond level_from_cam = LevelFromCam(Vector3d::UnitY());
  EXPECT_TRUE((level_from_cam * Vector3d::UnitZ()).isApprox(Vector3d::UnitX(), 1e-12));
  EXPECT_TRUE((level_from_cam * Vector3d::UnitX()).isApprox(-Vector3d::UnitY(), 1e-12));
}

TEST(LevelFromCam, LookingStraightUpOrDownTakesImageY) {
  for (const double sign : {1.0, -1.0}) {
    const Eigen::Quaterniond level_from_cam = LevelFromCam(sign * Vector3d::UnitZ());
    EXPECT_TRUE((level_from_cam * Vector3d::UnitY()).isApprox(Vector3d::UnitX(), 1e-12));
    EXPECT_TRUE((level_from_cam * (sign * Vector3d::UnitZ())).isApprox(-Vector3d::UnitZ(), 1e-12));
  }
}

TEST(LevelFromCam, LengthOfDownDoesNotMatter) {
  const Vector3d down_in_cam(0.1, 0.9, -0.3);
  EXPECT_TRUE(LevelFromCam(down_in_cam).isApprox(LevelFromCam(9.81 * down_in_cam), 1e-12));
}

}  // namespace
}  // namespace cairn
