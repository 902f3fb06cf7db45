#include "eval/evaluation_bootstrap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <vector>

namespace cairn {
namespace {

double MeanOf(const std::vector<double>& values, std::span<const size_t> sample) {
  double sum = 0.0;
  for (const size_t i : sample) {
    sum += values[i];
  }
  return sum / static_cast<double>(sample.size());
}

TEST(Bootstrap, HasTheStandardErrorOfTheMean) {
  // Half zeros, half ones: the mean of n = 100 has the standard error 0.5 / sqrt(100) = 0.05, the
  // interval reaches 1.96 of it to either side.
  std::vector<double> values(100);
  for (size_t i = 0; i < values.size(); ++i) {
    values[i] = i % 2 == 0 ? 0.0 : 1.0;
  }
  const Interval interval = Bootstrap(
      values.size(), [&](std::span<const size_t> sample) { return MeanOf(values, sample); });
  EXPECT_DOUBLE_EQ(interval.value, 0.5);
  EXPECT_NEAR(interval.low, 0.402, 0.021);
  EXPECT_NEAR(interval.high, 0.598, 0.021);
}

TEST(Bootstrap, DrawsAsManyQueriesAsThereAre) {
  std::set<size_t> sizes;
  Bootstrap(7, [&](std::span<const size_t> sample) {
    sizes.insert(sample.size());
    return 0.0;
  });
  EXPECT_EQ(sizes, std::set<size_t>{7});
}

TEST(Bootstrap, WithoutQueriesIsNotANumber) {
  const Interval interval = Bootstrap(0, [](std::span<const size_t>) { return 1.0; });
  EXPECT_TRUE(std::isnan(interval.value));
}

TEST(Bootstrap, IgnoresDrawingsWhereTheMeasureDoesNotExist) {
  // Only query 0 has a value; drawings without it do not count.
  const Interval interval = Bootstrap(3, [](std::span<const size_t> sample) {
    for (const size_t i : sample) {
      if (i == 0) {
        return 5.0;
      }
    }
    return std::numeric_limits<double>::quiet_NaN();
  });
  EXPECT_DOUBLE_EQ(interval.low, 5.0);
  EXPECT_DOUBLE_EQ(interval.high, 5.0);
}

TEST(GroupBootstrap, IsWiderIfFramesOfASequenceDependOnEachOther) {
  // Ten sequences of ten equal frames: the mean has the error of ten values, not of a hundred.
  std::vector<double> values(100);
  std::vector<int> sequences(100), each_its_own(100);
  for (int i = 0; i < 100; ++i) {
    sequences[i] = i / 10;
    each_its_own[i] = i;
    values[i] = (i / 10) % 2;
  }
  const auto mean = [&](std::span<const size_t> sample) { return MeanOf(values, sample); };
  const Interval dependent = GroupBootstrap(sequences, mean);
  const Interval independent = GroupBootstrap(each_its_own, mean);
  EXPECT_DOUBLE_EQ(dependent.value, independent.value);
  // 0.5 / sqrt(10) against 0.5 / sqrt(100).
  EXPECT_NEAR((dependent.high - dependent.low) / (independent.high - independent.low),
              std::sqrt(10.0), 0.4);
}

}  // namespace
}  // namespace cairn
