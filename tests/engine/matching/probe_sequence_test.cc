#include "engine/matching/probe_sequence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

namespace cairn {
namespace {

// All combinations of the steps, cheapest first, by enumeration. Bit i of a delta is step i.
std::vector<std::pair<int32_t, uint64_t>> AllCombinations(const std::vector<BorderStep>& steps) {
  std::vector<std::pair<int32_t, uint64_t>> combinations;
  for (uint64_t chosen = 0; chosen < uint64_t{1} << steps.size(); ++chosen) {
    int32_t sq_cost = 0;
    for (size_t i = 0; i < steps.size(); ++i) {
      sq_cost += (chosen >> i & 1) != 0 ? steps[i].sq_cost : 0;
    }
    combinations.emplace_back(sq_cost, chosen);
  }
  std::sort(combinations.begin(), combinations.end());
  return combinations;
}

std::vector<BorderStep> RandomSteps(size_t count, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<BorderStep> steps;
  for (size_t i = 0; i < count; ++i) {
    const auto distance = static_cast<int32_t>(random() % 1'000 + 1);
    steps.push_back({distance * distance, 0});
  }
  std::sort(steps.begin(), steps.end(),
            [](const BorderStep& a, const BorderStep& b) { return a.sq_cost < b.sq_cost; });
  for (size_t i = 0; i < count; ++i) {
    steps[i].delta = {uint64_t{1} << i, uint32_t{2} << i};
  }
  return steps;
}

int32_t CostOf(const std::vector<BorderStep>& steps, uint64_t delta) {
  int32_t sq_cost = 0;
  for (size_t i = 0; i < steps.size(); ++i) {
    sq_cost += (delta >> i & 1) != 0 ? steps[i].sq_cost : 0;
  }
  return sq_cost;
}

std::vector<Probe> SequenceOf(const std::vector<BorderStep>& steps, size_t num_probes) {
  std::vector<Probe> probes(num_probes);
  FillProbeSequence({.hash = 1'000'000, .crossed_dims = 1}, steps, probes);
  return probes;
}

TEST(ProbeSequence, VisitsTheCheapestCombinationsInOrderOnceEach) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    for (const size_t num_probes : {1, 2, 3, 4, 8, 31, 32}) {
      const std::vector<BorderStep> steps = RandomSteps(10, seed);
      const std::vector<Probe> probes = SequenceOf(steps, num_probes);
      const auto expected = AllCombinations(steps);
      std::vector<uint64_t> deltas;
      for (size_t i = 0; i < num_probes; ++i) {
        deltas.push_back(probes[i].hash - 1'000'000);
        EXPECT_EQ(CostOf(steps, deltas[i]), expected[i].first);
        EXPECT_EQ(probes[i].crossed_dims, 1 | deltas[i] << 1);
      }
      std::sort(deltas.begin(), deltas.end());
      EXPECT_EQ(std::unique(deltas.begin(), deltas.end()), deltas.end());
    }
  }
}

TEST(ProbeSequence, CoversAllNeighboursOfAFewDimensions) {
  std::vector<uint64_t> deltas;
  for (const Probe& probe : SequenceOf(RandomSteps(3, 7), 8)) {
    deltas.push_back(probe.hash - 1'000'000);
  }
  EXPECT_THAT(deltas, ::testing::UnorderedElementsAre(0, 1, 2, 3, 4, 5, 6, 7));
}

}  // namespace
}  // namespace cairn
