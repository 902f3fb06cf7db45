#include "engine/index/byte_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "engine/index/product_words.h"
#include "engine/simple_tile.h"
#include "engine/synthetic_descriptors.h"

namespace cairn {
namespace {

using testing::MakeSyntheticDescriptors;
using testing::SyntheticDescriptors;

// Squared distances of each descriptor to all words.
std::vector<std::vector<int32_t>> AllSqDistances(const ByteDescriptors& descriptors,
                                                 const ByteWords& words) {
  const std::vector<int16_t> steps(
      descriptors.rows(), descriptors.rows() + descriptors.size() * descriptors.scale().stride());
  const BlockQueries queries = words.Prepare(steps, descriptors.scale().stride());
  std::vector<std::vector<int32_t>> all;
  for (size_t i = 0; i < descriptors.size(); ++i) {
    std::vector<int32_t>& sq_steps = all.emplace_back(words.size() + kBlockRows);
    words.SqDistances(queries[i], sq_steps.data());
    sq_steps.resize(words.size());
  }
  return all;
}

// Squared distance of a descriptor to its word, summed over all descriptors.
double SumOfSquares(const ByteDescriptors& descriptors, const ByteWords& words) {
  double sum = 0.0;
  for (const std::vector<int32_t>& sq_steps : AllSqDistances(descriptors, words)) {
    sum += *std::min_element(sq_steps.begin(), sq_steps.end());
  }
  return sum;
}

TEST(ByteWords, FindSeparateClusters) {
  // Four values of the first dimension, a hundred descriptors each.
  std::vector<uint8_t> codes;
  for (int i = 0; i < 400; ++i) {
    codes.push_back(static_cast<uint8_t>(16 * (i % 4) * 4));
    codes.push_back(0);
  }
  const ByteDescriptors descriptors(*testing::LatticeCodebook(), codes);
  // Of ten random words at least one stands in each cluster.
  const ByteWords words(descriptors,
                        {.first_dim = 0, .num_dims = 4, .num_words = 10, .num_iterations = 5});
  const std::vector<uint32_t> nearest = words.NearestWords(descriptors);
  for (size_t i = 4; i < nearest.size(); ++i) {
    EXPECT_EQ(nearest[i], nearest[i % 4]);
  }
  EXPECT_EQ(std::set<uint32_t>(nearest.begin(), nearest.end()).size(), 4u);
  EXPECT_EQ(SumOfSquares(descriptors, words), 0.0);
}

TEST(ByteWords, IterationsBringThemNearer) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({});
  const ByteDescriptors descriptors(*data.codebook, data.codes);
  const ByteWords::Options none = {
      .first_dim = 0, .num_dims = 16, .num_words = 64, .num_iterations = 0};
  ByteWords::Options some = none;
  some.num_iterations = 8;
  EXPECT_LT(SumOfSquares(descriptors, ByteWords(descriptors, some)),
            0.8 * SumOfSquares(descriptors, ByteWords(descriptors, none)));
}

TEST(ByteWords, AreNoMoreThanDescriptors) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 10});
  const ByteDescriptors descriptors(*data.codebook, data.codes);
  const ByteWords words(descriptors, {.num_dims = 16, .num_words = 64, .num_iterations = 2});
  EXPECT_EQ(words.size(), 20u);
}

TEST(ProductWords, NearestDistanceIsThatOfTheNearestPair) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 500});
  const ByteDescriptors descriptors(*data.codebook, data.codes);
  const ByteScale& scale = descriptors.scale();
  const ProductWords words(descriptors, 20, 3, 1);
  EXPECT_EQ(words.num_cells(), 400u);
  const std::vector<double> distances = words.NearestDistances(scale, data.queries);
  const std::vector<int16_t> steps = scale.QuantizeQueries(data.queries);
  const BlockQueries first_queries = words.first().Prepare(steps, scale.stride());
  const BlockQueries second_queries = words.second().Prepare(steps, scale.stride());
  std::vector<int32_t> first(32), second(32);
  for (Eigen::Index query = 0; query < data.queries.rows(); ++query) {
    words.first().SqDistances(first_queries[query], first.data());
    words.second().SqDistances(second_queries[query], second.data());
    int32_t best = std::numeric_limits<int32_t>::max();
    for (int i = 0; i < 20; ++i) {
      for (int j = 0; j < 20; ++j) {
        best = std::min(best, first[i] + second[j]);
      }
    }
    EXPECT_NEAR(distances[query], scale.step() * std::sqrt(best), 1e-6);
  }
}

TEST(ProductWords, HalvesTogetherMeasureTheWholeDescriptor) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors(
      {.num_landmarks = 3, .descriptors_per_landmark = 1, .dim = 20, .num_subspaces = 5});
  const ByteDescriptors descriptors(*data.codebook, data.codes);
  const ProductWords words(descriptors, 3, 0, 1);
  // Without iterations the words are the descriptors, in the same random order in both halves.
  const std::vector<uint32_t> cells = words.NearestCells(descriptors);
  const auto first = AllSqDistances(descriptors, words.first());
  const auto second = AllSqDistances(descriptors, words.second());
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(cells[i] / 3, cells[i] % 3);
    EXPECT_EQ(first[i][cells[i] / 3] + second[i][cells[i] % 3], 0);
  }
}

}  // namespace
}  // namespace cairn
