#include "engine/index/probe_sequence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace cairn {
namespace {

// What the sequence makes of steps whose hashes tell them apart: bit i is the i-th shortest step.
std::vector<uint32_t> CombinationsOf(const ProbeSequence& sequence, int num_dims) {
  constexpr uint32_t kOwn = uint32_t{1} << 20;
  std::vector<uint32_t> steps;
  for (int i = 0; i < num_dims; ++i) {
    steps.push_back(uint32_t{1} << i);
  }
  std::vector<uint32_t> combinations(sequence.size());
  sequence.Fill(kOwn, steps, combinations.data());
  for (uint32_t& combination : combinations) {
    combination -= kOwn;
  }
  return combinations;
}

// Up to a factor, the mean squared length of a combination of the shortest of `num_dims` uniform
// steps.
int MeanSqLength(uint32_t combination) {
  int sq_length = 0;
  for (int i = 0; combination >> i != 0; ++i) {
    sq_length += (combination >> i & 1) != 0 ? (i + 1) * (i + 2) : 0;
  }
  return sq_length;
}

TEST(ProbeSequence, VisitsTheShortestCombinationsInOrderOnceEach) {
  for (const int num_dims : {3, 7, 10}) {
    std::vector<std::pair<int, uint32_t>> all;
    for (uint32_t combination = 0; combination < uint32_t{1} << num_dims; ++combination) {
      all.emplace_back(MeanSqLength(combination), combination);
    }
    std::sort(all.begin(), all.end());
    for (const int num_probes : {1, 2, 3, 8, 31, kMaxProbes}) {
      std::vector<uint32_t> combinations =
          CombinationsOf(ProbeSequence(num_dims, num_probes), num_dims);
      ASSERT_EQ(combinations.size(), std::min<size_t>(num_probes, all.size()));
      for (size_t i = 0; i < combinations.size(); ++i) {
        EXPECT_EQ(MeanSqLength(combinations[i]), all[i].first) << num_dims << " " << i;
      }
      std::sort(combinations.begin(), combinations.end());
      EXPECT_EQ(std::unique(combinations.begin(), combinations.end()), combinations.end());
    }
  }
}

TEST(ProbeSequence, UsesNoMoreStepsThanItSays) {
  const ProbeSequence sequence(10, 20);
  uint32_t used = 0;
  for (const uint32_t combination : CombinationsOf(sequence, 10)) {
    used |= combination;
  }
  EXPECT_EQ(used + 1, uint32_t{1} << sequence.num_steps());
}

TEST(ProbeSequence, CoversAllNeighborsOfAFewDimensions) {
  EXPECT_THAT(CombinationsOf(ProbeSequence(3, 100), 3),
              ::testing::UnorderedElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
  EXPECT_THAT(CombinationsOf(ProbeSequence(1, 100), 1), ::testing::ElementsAre(0, 1));
}

}  // namespace
}  // namespace cairn
