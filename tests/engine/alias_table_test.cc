#include "engine/pose/alias_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

namespace cairn {
namespace {

using ::testing::Each;

// How often each number is drawn.
std::vector<int> Counts(const AliasTable& table, int num_draws) {
  Random random(5);
  std::vector<int> counts(table.size(), 0);
  for (int i = 0; i < num_draws; ++i) {
    ++counts[table.Draw(&random)];
  }
  return counts;
}

TEST(AliasTable, DrawsInProportionToTheWeights) {
  constexpr int kNumDraws = 200'000;
  std::vector<double> weights = {3.0, 0.01, 0.0, 1.0, 0.5, 7.0};
  for (int i = 0; i < 100; ++i) {
    weights.push_back(0.1 * (i % 7));
  }
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  const std::vector<int> counts = Counts(AliasTable(weights), kNumDraws);
  for (size_t i = 0; i < weights.size(); ++i) {
    const double expected = kNumDraws * weights[i] / sum;
    EXPECT_NEAR(counts[i], expected, 5.0 * std::sqrt(expected)) << i;  // None at weight 0.
  }
}

TEST(AliasTable, OneWeightIsDrawnAlways) {
  EXPECT_THAT(Counts(AliasTable({0.25}), 10), Each(10));
  const std::vector<int> counts = Counts(AliasTable({0.0, 0.0, 1e-9, 0.0}), 1'000);
  EXPECT_EQ(counts[2], 1'000);
}

TEST(AliasTable, WithoutAnyWeightAllAreAlike) {
  EXPECT_THAT(Counts(AliasTable({0.0, 0.0, 0.0, 0.0}), 40'000),
              Each(::testing::AllOf(::testing::Gt(9'500), ::testing::Lt(10'500))));
}

TEST(AliasTable, EqualWeightsNeedNoOther) {
  EXPECT_THAT(Counts(AliasTable(std::vector<double>(4, 0.1)), 40'000),
              Each(::testing::AllOf(::testing::Gt(9'500), ::testing::Lt(10'500))));
}

TEST(AliasTable, MayBeEmpty) { EXPECT_EQ(AliasTable({}).size(), 0); }

}  // namespace
}  // namespace cairn
