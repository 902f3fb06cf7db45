#include "engine/index/byte_descriptors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "core/error.h"
#include "engine/synthetic_descriptors.h"
#include "storage/codebook/descriptor_codec.h"

namespace cairn {
namespace {

using testing::MakeSyntheticDescriptors;
using testing::SyntheticDescriptors;

TEST(ByteDescriptors, RowsAreTheDecodedCodesToHalfAStep) {
  for (const auto& [dim, num_subspaces] :
       std::vector<std::pair<int, int>>{{16, 8}, {16, 16}, {16, 4}, {20, 4}, {4, 1}, {128, 8}}) {
    const SyntheticDescriptors data = MakeSyntheticDescriptors(
        {.num_landmarks = 300, .num_queries = 100, .dim = dim, .num_subspaces = num_subspaces});
    const ByteScale scale(*data.codebook);
    EXPECT_EQ(scale.stride() % 16, 0);
    const std::vector<uint8_t> rows = scale.ExpandCodes(*data.codebook, data.codes);
    const DescriptorMatrix decoded = DescriptorCodec(data.codebook).Decode(data.codes.data(), 600);
    const std::vector<int16_t> steps = scale.QuantizeQueries(decoded);
    ASSERT_EQ(rows.size(), steps.size());
    // Words and queries are rounded alike, so a decoded code lies on its own row; padding is 0.
    for (size_t i = 0; i < rows.size(); ++i) {
      ASSERT_NEAR(rows[i], steps[i], 1) << "dim " << dim << " at " << i;
      if (static_cast<int>(i % scale.stride()) >= dim) {
        ASSERT_EQ(rows[i], 0);
      }
    }
  }
}

TEST(ByteScale, WordsLieAboutTheMiddleOfAByte) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 300});
  const std::vector<uint8_t> bytes = ByteScale(*data.codebook).WordBytes(*data.codebook);
  const int dim = data.codebook->subspace_dim();
  int widest = 0;
  for (int of_code = 0; of_code < data.codebook->projected_dim(); ++of_code) {
    int least = 255, most = 0;
    for (int word = 0; word < Codebook::kNumWords; ++word) {
      const uint8_t byte =
          bytes[size_t{1} * (of_code / dim * Codebook::kNumWords + word) * dim + of_code % dim];
      least = std::min<int>(least, byte);
      most = std::max<int>(most, byte);
    }
    EXPECT_NEAR(least + most, 255, 1) << of_code;
    widest = std::max(widest, most - least);
  }
  EXPECT_EQ(widest, 255);
}

TEST(ByteDescriptors, ExhaustiveSearchAgreesWithFloatDistances) {
  const SyntheticDescriptors data =
      MakeSyntheticDescriptors({.num_landmarks = 1500, .num_queries = 60});
  const ByteDescriptors descriptors(*data.codebook, data.codes);
  const DescriptorMatrix decoded =
      DescriptorCodec(data.codebook)
          .Decode(data.codes.data(), static_cast<int>(descriptors.size()));
  const float max_distance = data.codebook->same_landmark_distance_quantiles[17];
  // Rounding moves each of 16 coordinates of both sides by half a step at most.
  const float tolerance = 4.0f * descriptors.scale().step();
  std::vector<DescriptorHit> hits;
  descriptors.RangeSearch(data.queries, max_distance, &hits);
  ASSERT_FALSE(hits.empty());
  std::map<std::pair<uint32_t, uint32_t>, float> found;
  for (const DescriptorHit& hit : hits) {
    found[{hit.query_idx, hit.descriptor_idx}] = std::sqrt(hit.sq_distance);
  }
  EXPECT_EQ(found.size(), hits.size());
  for (uint32_t query = 0; query < data.queries.rows(); ++query) {
    for (uint32_t i = 0; i < decoded.rows(); ++i) {
      const float distance = (decoded.row(i) - data.queries.row(query)).norm();
      const auto hit = found.find({query, i});
      if (hit != found.end()) {
        ASSERT_NEAR(hit->second, distance, tolerance);
      } else {
        ASSERT_GT(distance, max_distance - tolerance);
      }
    }
  }
}

TEST(ByteDescriptors, HitsAreOrderedByQueryThenDescriptor) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_queries = 50});
  std::vector<DescriptorHit> hits;
  ByteDescriptors(*data.codebook, data.codes).RangeSearch(data.queries, 0.4, &hits);
  ASSERT_GT(hits.size(), 1'000u);
  EXPECT_TRUE(std::is_sorted(hits.begin(), hits.end(), [](const auto& a, const auto& b) {
    return std::pair(a.query_idx, a.descriptor_idx) < std::pair(b.query_idx, b.descriptor_idx);
  }));
}

TEST(ByteDescriptors, ExtremeQueriesAreClampedAndMatchNothing) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 10});
  const ByteDescriptors descriptors(*data.codebook, data.codes);
  DescriptorMatrix queries = DescriptorMatrix::Constant(3, 16, 1e30f);
  queries.row(1) *= -1.0f;
  queries.row(2).setConstant(std::numeric_limits<float>::quiet_NaN());
  std::vector<DescriptorHit> hits;
  descriptors.RangeSearch(queries, data.codebook->same_landmark_distance_quantiles[18], &hits);
  EXPECT_THAT(hits, ::testing::IsEmpty());
}

TEST(ByteDescriptors, CodebookOfOneWordStillWorks) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 4});
  Codebook codebook = *data.codebook;
  std::fill(codebook.words.begin(), codebook.words.end(), 0.5f);
  std::vector<DescriptorHit> hits;
  ByteDescriptors(codebook, data.codes)
      .RangeSearch(DescriptorMatrix::Constant(1, 16, 0.5f), 0.1, &hits);
  EXPECT_EQ(hits.size(), 8u);
}

TEST(ByteDescriptors, RefuseAQueryOfAnotherDimension) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 10});
  const ByteDescriptors descriptors(*data.codebook, data.codes);
  std::vector<DescriptorHit> hits;
  EXPECT_THROW(descriptors.RangeSearch(DescriptorMatrix::Zero(1, 8), 1.0, &hits), Error);
}

}  // namespace
}  // namespace cairn
