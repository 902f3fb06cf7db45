#include "engine/pose/ransac.h"

#include <gtest/gtest.h>

#include <vector>

namespace cairn {
namespace {

// Finds the most frequent of some numbers. The model of a sample is the number drawn plus noise
// that optimization takes away.
class ModeProblem {
 public:
  using Model = double;
  static constexpr int kMaxModels = 1;

  explicit ModeProblem(std::vector<int> numbers) : numbers_(std::move(numbers)) {}

  int SampleModels(Random* random, std::array<Model, kMaxModels>* models) {
    (*models)[0] = numbers_[random->Index(static_cast<int>(numbers_.size()))] + 0.25;
    return 1;
  }
  double ScoreMinimal(Model model, double) { return Count(std::round(model)); }
  std::optional<std::pair<Model, double>> Optimize(Model model) {
    ++num_optimizations;
    return std::pair(std::round(model), Count(std::round(model)));
  }
  double InlierSampleProbability(Model model) {
    return Count(model) / static_cast<double>(numbers_.size());
  }
  double SampleProbabilityOfScore(double score) {
    return score / static_cast<double>(numbers_.size());
  }

  int num_optimizations = 0;

 private:
  double Count(double value) const {
    return static_cast<double>(
        std::count(numbers_.begin(), numbers_.end(), static_cast<int>(value)));
  }
  std::vector<int> numbers_;
};

std::vector<int> Numbers(int num_sevens, int num_others) {
  std::vector<int> numbers(num_sevens, 7);
  for (int i = 0; i < num_others; ++i) {
    numbers.push_back(100 + i);
  }
  return numbers;
}

TEST(RequiredIterations, FollowsTheConfidenceBound) {
  RansacOptions options;
  options.min_iterations = 1;
  options.max_iterations = 100'000;
  options.success_probability = 0.99;
  EXPECT_EQ(RequiredIterations(0.5, options), 7);     // ln 0.01 / ln 0.5 = 6.6
  EXPECT_EQ(RequiredIterations(0.01, options), 459);  // ln 0.01 / ln 0.99 = 458.2
}

TEST(LoRansac, WithAScoreToReachStopsWhenItWouldHaveBeenReached) {
  RansacOptions options;
  options.min_iterations = 1;
  options.max_iterations = 100'000;
  options.success_probability = 0.99;
  ModeProblem nothing_good(Numbers(0, 100));
  options.min_score = 50.0;
  const auto result = LoRansac(&nothing_good, options, 1);
  EXPECT_FALSE(result.model);
  EXPECT_EQ(result.num_iterations, 7);  // As for a half of inliers.
  ModeProblem better(Numbers(60, 40));
  EXPECT_EQ(LoRansac(&better, options, 1).model, 7.0);
  ModeProblem worse(Numbers(40, 60));
  EXPECT_FALSE(LoRansac(&worse, options, 1).model);
}

TEST(RequiredIterations, StaysWithinBounds) {
  RansacOptions options;
  options.min_iterations = 10;
  options.max_iterations = 500;
  EXPECT_EQ(RequiredIterations(1.0, options), 10);
  EXPECT_EQ(RequiredIterations(0.0, options), 500);
  EXPECT_EQ(RequiredIterations(1e-300, options), 500);
}

TEST(LoRansac, ReturnsOptimizedModel) {
  ModeProblem problem(Numbers(30, 70));
  const auto result = LoRansac(&problem, RansacOptions(), 1);
  ASSERT_TRUE(result.model);
  EXPECT_EQ(*result.model, 7.0);
  EXPECT_EQ(result.score, 30.0);
}

TEST(LoRansac, StopsEarlyWhenTheModelExplainsEnough) {
  RansacOptions options;
  options.min_iterations = 5;
  ModeProblem problem(Numbers(90, 10));
  EXPECT_EQ(LoRansac(&problem, options, 1).num_iterations, 5);
  ModeProblem hard(Numbers(2, 98));
  EXPECT_GT(LoRansac(&hard, options, 1).num_iterations, 100);
}

TEST(LoRansac, OptimizesOnlyImprovements) {
  ModeProblem problem(Numbers(50, 50));
  LoRansac(&problem, RansacOptions(), 1);
  EXPECT_LE(problem.num_optimizations, 2);  // A single number may come first.
}

TEST(LoRansac, SameSeedSameResult) {
  for (const uint64_t seed : {1u, 2u, 3u}) {
    ModeProblem a(Numbers(3, 97)), b(Numbers(3, 97));
    const auto first = LoRansac(&a, RansacOptions(), seed);
    const auto second = LoRansac(&b, RansacOptions(), seed);
    EXPECT_EQ(first.model, second.model);
    EXPECT_EQ(first.num_iterations, second.num_iterations);
  }
}

TEST(Random, CoversTheRangeEvenly) {
  Random random(1);
  std::vector<int> counts(10, 0);
  for (int i = 0; i < 10'000; ++i) {
    const int index = random.Index(10);
    ASSERT_GE(index, 0);
    ASSERT_LT(index, 10);
    ++counts[index];
  }
  for (const int count : counts) {
    EXPECT_NEAR(count, 1000, 150);
  }
}

}  // namespace
}  // namespace cairn
