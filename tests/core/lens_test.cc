#include "core/lens.h"

#include <gtest/gtest.h>

#include <optional>

namespace cairn {
namespace {

// Expects that Undistort finds the point that Distort was given.
void ExpectInverse(const Lens& lens, const Eigen::Vector2d& normalized) {
  const std::optional<Eigen::Vector2d> distorted = lens.Distort(normalized, nullptr);
  ASSERT_TRUE(distorted) << normalized.transpose();
  const std::optional<Eigen::Vector2d> again = lens.Undistort(*distorted);
  ASSERT_TRUE(again) << normalized.transpose();
  EXPECT_LT((*again - normalized).norm(), 1e-9) << normalized.transpose();
}

// Three radii have the same distorted radius, between 0.566 and 0.6.
TEST(Lens, UndistortsToTheFirstOfSeveralRadii) {
  // r (1 - 0.5 r^2 + 0.1 r^4) grows up to r = 1, where it is 0.6, falls up to r = 1.41, and grows
  // again.
  const Lens lens(LensCoefficients{.numerator = {-0.5, 0.1}});
  for (const double radius : {0.1, 0.5, 0.8, 0.9, 0.95, 0.99}) {
    ExpectInverse(lens, {0.6 * radius, -0.8 * radius});
  }
  for (const double radius : {1.01, 1.2, 1.5, 2.0}) {
    EXPECT_FALSE(lens.Distort({radius, 0.0}, nullptr)) << radius;
  }
  EXPECT_FALSE(lens.Undistort({0.61, 0.0}));
  EXPECT_FALSE(lens.Undistort({1.2, 0.0}));  // That of r = 2.
}

// Near the pole, the distorted radius is many times the radius of the pole.
TEST(Lens, UndistortsUpToThePoleOfARationalFactor) {
  const Lens lens(LensCoefficients{.denominator = {-0.5}});  // r / (1 - 0.5 r^2).
  for (const double radius : {0.3, 0.8, 0.9, 1.1, 1.3, 1.4}) {
    ExpectInverse(lens, {0.6 * radius, 0.8 * radius});
  }
  EXPECT_FALSE(lens.Distort({1.5, 0.0}, nullptr));
}

// v + 0.6 v^2 falls up to v = -0.83, where it is -0.417: smaller values of v fold back.
TEST(Lens, UndistortsToThisSideOfATangentialFold) {
  const Lens lens(LensCoefficients{.p1 = 0.2});
  for (const double v : {-0.75, -0.5, 0.0, 0.5, 2.0}) {
    ExpectInverse(lens, {0.0, v});
  }
  const std::optional<Eigen::Vector2d> folded = lens.Distort({0.0, -1.2}, nullptr);
  ASSERT_TRUE(folded);
  const std::optional<Eigen::Vector2d> undistorted = lens.Undistort(*folded);
  ASSERT_TRUE(undistorted);
  EXPECT_NEAR(undistorted->y(), -1.4 / 3.0, 1e-9);  // The other root.
  EXPECT_FALSE(lens.Undistort({0.0, -0.45}));
}

}  // namespace
}  // namespace cairn
