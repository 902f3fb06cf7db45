#include "core/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/angles.h"

namespace cairn {
namespace {

TEST(Quantile, InterpolatesBetweenRanks) {
  EXPECT_DOUBLE_EQ(Quantile({4.0, 1.0, 2.0, 3.0}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(Quantile({0.0, 10.0}, 0.025), 0.25);
  EXPECT_DOUBLE_EQ(Quantile({7.0}, 0.9), 7.0);
}

TEST(ValueAtShare, IsOneOfTheValues) {
  const std::vector<float> values = {3.0f, 1.0f, 2.0f, 5.0f, 4.0f};
  EXPECT_EQ(ValueAtShare(values, 0.0), 1.0f);
  EXPECT_EQ(ValueAtShare(values, 0.5), 3.0f);
  EXPECT_EQ(ValueAtShare(values, 0.7), 3.0f);
  EXPECT_EQ(ValueAtShare(values, 1.0), 5.0f);
}

TEST(CircularMean, LiesBetweenTheAnglesAlsoAcrossPi) {
  CircularMean mean;
  EXPECT_FALSE(mean.AngleRad());
  mean.Add(kPi - 0.1);
  mean.Add(-kPi + 0.3);
  EXPECT_NEAR(*mean.AngleRad(), -kPi + 0.1, 1e-12);
  mean.Add(-kPi + 0.3, 1e6);
  EXPECT_NEAR(*mean.AngleRad(), -kPi + 0.3, 1e-6);
}

TEST(CircularMean, IsNothingIfTheAnglesCancel) {
  CircularMean mean;
  mean.Add(0.5);
  mean.Add(0.5 - kPi);
  EXPECT_FALSE(mean.AngleRad());
}

}  // namespace
}  // namespace cairn
