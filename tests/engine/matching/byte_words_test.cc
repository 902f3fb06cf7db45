#include "engine/matching/byte_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "engine/matching/product_words.h"
#include "engine/matching/simple_tile.h"
#include "engine/matching/synthetic_descriptors.h"

namespace cairn {
namespace {

using testing::MakeSyntheticDescriptors;
using testing::SyntheticDescriptors;

// Squared distance of a descriptor to its word, summed over all descriptors.
double SumOfSquares(const ByteDescriptors& descriptors, const ByteWords& words) {
  std::vector<int32_t> sq_steps(words.size());
  std::vector<int16_t> query(descriptors.scale().stride());
  double sum = 0.0;
  for (size_t i = 0; i < descriptors.size(); ++i) {
    const uint8_t* row = descriptors.rows() + i * query.size();
    std::copy(row, row + query.size(), query.begin());
    words.SqDistances(query.data(), sq_steps);
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
  std::vector<int32_t> first(20), second(20);
  for (Eigen::Index query = 0; query < data.queries.rows(); ++query) {
    words.first().SqDistances(steps.data() + query * scale.stride(), first);
    words.second().SqDistances(steps.data() + query * scale.stride(), second);
    int32_t best = std::numeric_limits<int32_t>::max();
    for (const int32_t a : first) {
      for (const int32_t b : second) {
        best = std::min(best, a + b);
      }
    }
    EXPECT_NEAR(distances[query], scale.step() * std::sqrt(best), 1e-6);
  }
}

TEST(ProductWords, HalvesTogetherMeasureTheWholeDescriptor) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors(
      {.num_landmarks = 3, .descriptors_per_landmark = 1, .dim = 20, .num_subspaces = 5});
  const ByteDescriptors descriptors(*data.codebook, data.codes);
  const ByteScale& scale = descriptors.scale();
  const ProductWords words(descriptors, 3, 0, 1);
  // Without iterations the words are the descriptors, in the same random order in both halves.
  const std::vector<uint32_t> cells = words.NearestCells(descriptors);
  std::vector<int32_t> first(3), second(3), whole(1);
  for (int i = 0; i < 3; ++i) {
    const std::vector<int16_t> query(descriptors.rows() + i * scale.stride(),
                                     descriptors.rows() + (i + 1) * scale.stride());
    words.first().SqDistances(query.data(), first);
    words.second().SqDistances(query.data(), second);
    EXPECT_EQ(cells[i] / 3, cells[i] % 3);
    EXPECT_EQ(first[cells[i] / 3] + second[cells[i] % 3], 0);
  }
}

}  // namespace
}  // namespace cairn
