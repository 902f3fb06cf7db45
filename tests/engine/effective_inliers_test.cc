#include "engine/pose/effective_inliers.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/angles.h"

namespace cairn {
namespace {

using Pixels = std::vector<Eigen::Vector2d>;

constexpr int kWidth = 640, kHeight = 480;
constexpr double kRadiusPx = 25.0;  // The diagonal is 800 px.

TEST(EffectiveInliers, NoneForNone) { EXPECT_EQ(EffectiveInliers({}, kWidth, kHeight), 0.0); }

TEST(EffectiveInliers, CountsInliersFarApart) {
  const Pixels pixels = {{100, 100}, {300, 100}, {100, 300}, {500, 400}};
  EXPECT_DOUBLE_EQ(EffectiveInliers(pixels, kWidth, kHeight), 4.0);
}

TEST(EffectiveInliers, CoincidingInliersCountOnce) {
  EXPECT_DOUBLE_EQ(EffectiveInliers(Pixels(50, {320, 240}), kWidth, kHeight), 1.0);
}

TEST(EffectiveInliers, TwoOverlappingDiscsCoverTheirUnion) {
  // Discs of radius r at distance r share (2 pi / 3 - sqrt(3) / 2) r^2.
  const double shared = 2.0 * kPi / 3.0 - std::sqrt(3.0) / 2.0;
  const double expected = 2.0 * (2.0 * kPi - shared) / (2.0 * kPi);
  EXPECT_NEAR(EffectiveInliers({{300, 240}, {300 + kRadiusPx, 240}}, kWidth, kHeight), expected,
              0.03);
}

TEST(EffectiveInliers, CrowdInACornerCountsLessThanSpread) {
  Pixels crowd, spread;
  for (int i = 0; i < 100; ++i) {
    crowd.emplace_back(20.0 + 6.0 * (i % 10), 20.0 + 6.0 * (i / 10));
    spread.emplace_back(32.0 + 64.0 * (i % 10), 24.0 + 48.0 * (i / 10));
  }
  EXPECT_LT(EffectiveInliers(crowd, kWidth, kHeight), 12.0);
  EXPECT_GT(EffectiveInliers(spread, kWidth, kHeight), 95.0);
}

TEST(EffectiveInliers, DoesNotDependOnResolution) {
  const Pixels pixels = {{100, 100}, {120, 105}, {400, 50}};
  Pixels doubled;
  for (const Eigen::Vector2d& pixel : pixels) {
    doubled.push_back(2.0 * pixel);
  }
  EXPECT_DOUBLE_EQ(EffectiveInliers(pixels, kWidth, kHeight),
                   EffectiveInliers(doubled, 2 * kWidth, 2 * kHeight));
}

TEST(EffectiveInliers, IsBoundedByTheImage) {
  Pixels everywhere;
  for (int i = 0; i < 20'000; ++i) {
    everywhere.emplace_back(std::fmod(i * 7.31, kWidth), std::fmod(i * 3.77, kHeight));
  }
  const double count = EffectiveInliers(everywhere, kWidth, kHeight);
  EXPECT_GT(count, 150.0);
  EXPECT_LT(count, 200.0);
}

TEST(EffectiveInliers, HandlesPixelsOutsideAndTinyOrFlatImages) {
  EXPECT_DOUBLE_EQ(EffectiveInliers({{-500, -500}, {5000, 5000}}, kWidth, kHeight), 2.0);
  EXPECT_DOUBLE_EQ(EffectiveInliers({{0.5, 0.5}}, 1, 1), 1.0);
  EXPECT_DOUBLE_EQ(EffectiveInliers({{10, 0.5}, {90'000, 0.5}}, 100'000, 1), 2.0);
}

}  // namespace
}  // namespace cairn
