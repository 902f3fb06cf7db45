#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>
#include <set>

#include "ingest/tiles/landmark_coverage.h"

namespace cairn {
namespace {

struct Instance {
  VisibilityGraph graph;
  std::vector<int> num_descriptors;
  LandmarkSelectionOptions options;
};

int64_t Cost(const Instance& instance, uint32_t landmark) {
  return instance.options.max_landmarks > 0 ? 1 : instance.num_descriptors[landmark];
}

int64_t Budget(const Instance& instance) {
  return instance.options.max_landmarks > 0 ? instance.options.max_landmarks
                                            : instance.options.max_descriptors;
}

// The objective as landmark_coverage.h defines it; minus infinity beyond the budget.
double Objective(const Instance& instance, const std::vector<uint32_t>& selection) {
  const std::set<uint32_t> chosen(selection.begin(), selection.end());
  int64_t cost = 0;
  double objective = 0.0;
  for (const uint32_t i : chosen) {
    cost += Cost(instance, i);
    objective += instance.graph.num_observations[i];
  }
  for (const std::vector<uint32_t>& landmarks : instance.graph.landmarks_of_keyframe) {
    const auto is_candidate = [&](uint32_t i) {
      return instance.graph.num_observations[i] >= instance.options.min_observations;
    };
    const auto num_seen =
        static_cast<int>(std::count_if(landmarks.begin(), landmarks.end(), is_candidate));
    const auto num_kept =
        static_cast<int>(std::count_if(landmarks.begin(), landmarks.end(), [&](uint32_t i) {
          return is_candidate(i) && chosen.contains(i);
        }));
    objective -=
        instance.options.missing_landmark_cost *
        std::max(0, std::min(num_seen, instance.options.min_landmarks_per_keyframe) - num_kept);
  }
  return cost <= Budget(instance) ? objective : -std::numeric_limits<double>::infinity();
}

double BestByEnumeration(const Instance& instance) {
  const auto num_landmarks = static_cast<uint32_t>(instance.graph.num_landmarks());
  double best = -std::numeric_limits<double>::infinity();
  for (uint32_t subset = 0; subset < uint32_t{1} << num_landmarks; ++subset) {
    std::vector<uint32_t> selection;
    for (uint32_t i = 0; i < num_landmarks; ++i) {
      const bool is_in = subset >> i & 1;
      if (is_in && instance.graph.num_observations[i] >= instance.options.min_observations) {
        selection.push_back(i);
      }
    }
    best = std::max(best, Objective(instance, selection));
  }
  return best;
}

// Landmarks along a street; keyframes see those about them. Some stretches are rich in landmarks
// that are seen often, so that taking the most observed leaves others bare.
Instance StreetInstance(int num_landmarks, int num_keyframes, uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::uniform_real_distribution<double> uniform;
  Instance instance;
  instance.graph.landmarks_of_keyframe.resize(num_keyframes);
  for (int i = 0; i < num_landmarks; ++i) {
    const double along = uniform(rng);
    const double reach = 0.02 + (along < 0.5 ? 0.15 : 0.05) * uniform(rng);
    int num_observations = 0;
    for (int k = 0; k < num_keyframes; ++k) {
      if (std::abs((k + 0.5) / num_keyframes - along) < reach) {
        instance.graph.landmarks_of_keyframe[k].push_back(static_cast<uint32_t>(i));
        ++num_observations;
      }
    }
    instance.graph.num_observations.push_back(num_observations);
    instance.num_descriptors.push_back(std::max(1, num_observations / 4));
  }
  return instance;
}

TEST(SolveCoverage, AgreesWithEnumerationOnSmallInstances) {
  int num_proved = 0;
  for (uint64_t seed = 0; seed < 40; ++seed) {
    Instance instance = StreetInstance(12, 8, seed);
    instance.options.min_landmarks_per_keyframe = 2;
    instance.options.missing_landmark_cost = 5.0;
    instance.options.max_landmarks = seed % 2 == 0 ? 4 : 0;
    instance.options.max_descriptors = 5;
    const double best = BestByEnumeration(instance);
    const CoverageSolution solution =
        SolveCoverage(instance.graph, instance.num_descriptors, instance.options);
    EXPECT_DOUBLE_EQ(solution.objective, Objective(instance, solution.selection)) << seed;
    EXPECT_GE(solution.upper_bound, best - 1e-9) << seed;
    EXPECT_LE(solution.objective, best + 1e-9) << seed;
    // Swaps of one for one are not exact.
    EXPECT_GE(solution.objective, best - 0.1 * std::abs(best)) << seed;
    num_proved += solution.objective > best - 1e-9 ? 1 : 0;
  }
  EXPECT_GE(num_proved, 32);
}

TEST(SolveCoverage, BindingStreetIsSolvedNearlyToOptimality) {
  Instance instance = StreetInstance(6000, 120, 7);
  instance.options.min_landmarks_per_keyframe = 60;
  instance.options.max_landmarks = 800;
  const CoverageSolution solution =
      SolveCoverage(instance.graph, instance.num_descriptors, instance.options);
  EXPECT_LT(solution.Gap(), 1e-2);
  EXPECT_EQ(solution.selection.size(), 800u);
  EXPECT_DOUBLE_EQ(solution.objective, Objective(instance, solution.selection));

  std::vector<uint32_t> most_observed(instance.graph.num_landmarks());
  std::iota(most_observed.begin(), most_observed.end(), 0u);
  std::stable_sort(most_observed.begin(), most_observed.end(), [&](uint32_t a, uint32_t b) {
    return instance.graph.num_observations[a] > instance.graph.num_observations[b];
  });
  most_observed.resize(800);
  EXPECT_GT(solution.objective, Objective(instance, most_observed) + 1000.0);  // It does bind.
}

TEST(SolveCoverage, CoversKeyframesBeforeItCollectsObservations) {
  Instance instance = StreetInstance(3000, 60, 3);
  instance.options.min_landmarks_per_keyframe = 10;
  instance.options.max_descriptors = 600;
  const CoverageSolution solution =
      SolveCoverage(instance.graph, instance.num_descriptors, instance.options);
  EXPECT_EQ(solution.num_missing, 0);
  int64_t cost = 0;
  for (const uint32_t i : solution.selection) {
    cost += instance.num_descriptors[i];
  }
  EXPECT_LE(cost, 600);
  EXPECT_GE(cost, 590);
}

TEST(SolveCoverage, WithRoomForAllKeepsAllThatAreObservedEnough) {
  Instance instance = StreetInstance(50, 10, 1);
  instance.graph.num_observations[7] = 1;
  const CoverageSolution solution =
      SolveCoverage(instance.graph, instance.num_descriptors, instance.options);
  size_t num_enough = 0;
  for (const int count : instance.graph.num_observations) {
    num_enough += count >= 2 ? 1 : 0;
  }
  EXPECT_EQ(solution.selection.size(), num_enough);
  EXPECT_FALSE(std::binary_search(solution.selection.begin(), solution.selection.end(), 7u));
  EXPECT_EQ(solution.Gap(), 0.0);
}

TEST(SolveCoverage, NothingToChooseFromIsNoError) {
  EXPECT_TRUE(SolveCoverage({}, {}, {}).selection.empty());
  const VisibilityGraph no_keyframes = {.num_observations = {5, 4, 3}, .landmarks_of_keyframe = {}};
  EXPECT_EQ(SolveCoverage(no_keyframes, {1, 1, 1}, {.max_descriptors = 2}).selection,
            (std::vector<uint32_t>{0, 1}));
  const VisibilityGraph all_rare = {.num_observations = {1, 1}, .landmarks_of_keyframe = {{0, 1}}};
  EXPECT_TRUE(SolveCoverage(all_rare, {1, 1}, {}).selection.empty());
  EXPECT_TRUE(SolveCoverage(no_keyframes, {9, 9, 9}, {.max_descriptors = 2}).selection.empty());
}

TEST(SolveCoverage, SameInputSameAnswer) {
  const Instance instance = StreetInstance(2000, 40, 11);
  LandmarkSelectionOptions options = {.max_landmarks = 300, .min_landmarks_per_keyframe = 30};
  EXPECT_EQ(SolveCoverage(instance.graph, instance.num_descriptors, options).selection,
            SolveCoverage(instance.graph, instance.num_descriptors, options).selection);
}

TEST(LandmarkSelector, TheKindNamesTheSelector) {
  const Instance instance = StreetInstance(2000, 40, 11);
  LandmarkSelectionOptions options = {.max_descriptors = 400, .min_landmarks_per_keyframe = 30};
  const auto by_count = MakeLandmarkSelector(options);
  EXPECT_EQ(
      by_count->Select(instance.graph, instance.num_descriptors),
      MakeObservationCountSelector(options)->Select(instance.graph, instance.num_descriptors));
  options.kind = LandmarkSelectionKind::kCoverage;
  EXPECT_EQ(MakeLandmarkSelector(options)->Select(instance.graph, instance.num_descriptors),
            SolveCoverage(instance.graph, instance.num_descriptors, options).selection);
}

}  // namespace
}  // namespace cairn
