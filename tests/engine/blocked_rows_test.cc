#include "engine/index/blocked_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <random>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/index/byte_scale.h"
#include "engine/index/distance_kernels.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

using ::testing::ElementsAreArray;

// Random rows and queries; some queries reach far beyond the rows, some have narrow pairs.
struct Scene {
  Scene(int stride_in, size_t num_rows, uint64_t seed)
      : stride(stride_in), rows(num_rows * stride) {
    std::mt19937_64 random(seed);
    for (uint8_t& value : rows) {
      value = static_cast<uint8_t>(random() % 256);
    }
    for (int query = 0; query < kNumQueries; ++query) {
      const int reach = query % 4 == 0 ? 1024 : query % 4 == 1 ? 300 : 0;
      for (int dim = 0; dim < stride; ++dim) {
        if (query % 4 == 3) {
          // Some below the middle, whose constant is negative.
          steps.push_back(static_cast<int16_t>(65 + random() % (query % 8 == 3 ? 64 : 127)));
          continue;
        }
        steps.push_back(static_cast<int16_t>(static_cast<int>(random() % (256 + reach)) -
                                             (random() % 2 == 0 ? reach : 0)));
      }
    }
    order.resize(num_rows);
    std::iota(order.begin(), order.end(), 0u);
    std::shuffle(order.begin(), order.end(), random);
  }

  // Squared distances to the rows in order.
  std::vector<int32_t> Expected(int query) const {
    const DistanceKernels& plain = *SupportedDistanceKernels().front();
    std::vector<int32_t> sq_distances(order.size());
    for (size_t i = 0; i < order.size(); ++i) {
      plain.scan(steps.data() + query * stride, rows.data() + size_t{order[i]} * stride, stride, 1,
                 &sq_distances[i]);
    }
    return sq_distances;
  }

  // The smallest distance at each place of a block over each part of the blocks; kNone without
  // rows.
  std::vector<int32_t> ExpectedMinima(int query, size_t num_parts) const {
    const std::vector<int32_t> sq_distances = Expected(query);
    const size_t num_blocks = (order.size() + kBlockRows - 1) / kBlockRows;
    std::vector<int32_t> minima(num_parts * kBlockRows, kNone);
    for (size_t part = 0; part < num_parts; ++part) {
      const size_t end = std::min(order.size(), (part + 1) * num_blocks / num_parts * kBlockRows);
      for (size_t row = part * num_blocks / num_parts * kBlockRows; row < end; ++row) {
        int32_t& minimum = minima[part * kBlockRows + row % kBlockRows];
        minimum = std::min(minimum, sq_distances[row]);
      }
    }
    return minima;
  }

  static constexpr int32_t kNone = std::numeric_limits<int32_t>::max();
  static constexpr int kNumQueries = 12;
  int stride;
  std::vector<uint8_t> rows;
  std::vector<int16_t> steps;
  std::vector<uint32_t> order;
};

// What a variant finds for Scene::ExpectedMinima; rows of the padding are none.
std::vector<int32_t> MinimaOf(const BlockedRows& rows, const BlockKernels& kernels,
                              const BlockQuery& query, size_t num_parts) {
  constexpr int32_t kPaddingAtLeast = 1 << 29;
  std::vector<int32_t> minima(num_parts * kBlockRows);
  rows.MinimaWith(kernels, query, num_parts, minima.data());
  for (int32_t& minimum : minima) {
    minimum = minimum >= kPaddingAtLeast ? Scene::kNone : minimum;
  }
  return minima;
}

// What a variant finds of a range, and what it should: rows and distances.
using Hits = std::vector<std::pair<uint32_t, int32_t>>;

Hits RangeOf(const BlockedRows& rows, const BlockKernels& kernels, const BlockQuery& query,
             size_t begin, size_t end, int32_t bound) {
  std::vector<BlockHit> found(rows.size() + kRangeSlack);
  found.resize(rows.RangeWith(kernels, query, begin, end, bound, found.data()));
  Hits hits;
  for (const BlockHit& hit : found) {
    hits.emplace_back(hit.row, hit.sq_distance);
  }
  return hits;
}

Hits ExpectedRange(const std::vector<int32_t>& sq_distances, size_t begin, size_t end,
                   int32_t bound) {
  Hits hits;
  for (size_t row = begin; row < end; ++row) {
    if (sq_distances[row] <= bound) {
      hits.emplace_back(static_cast<uint32_t>(row), sq_distances[row]);
    }
  }
  return hits;
}

// The stride and the center of the rows.
class BlockKernelsTest : public ::testing::TestWithParam<std::tuple<int, uint8_t>> {};

// Every variant against plain distances row by row, as the variant would be used by BlockedRows.
TEST_P(BlockKernelsTest, EveryVariantGivesTheSame) {
  const auto [stride, center] = GetParam();
  for (const size_t num_rows : {1u, 15u, 16u, 17u, 100u}) {
    const Scene scene(stride, num_rows, num_rows);
    const BlockedRows blocked(scene.rows.data(), stride, scene.order, center);
    const BlockQueries queries(scene.steps, blocked.centers());
    ASSERT_EQ(queries.size(), static_cast<size_t>(Scene::kNumQueries));
    for (const BlockKernels* kernels : SupportedBlockKernels()) {
      SCOPED_TRACE(kernels->name);
      for (int query = 0; query < Scene::kNumQueries; ++query) {
        const std::vector<int32_t> expected = scene.Expected(query);
        std::vector<int32_t> scanned(blocked.padded_size());
        blocked.ScanWith(*kernels, queries[query], scanned.data());
        scanned.resize(num_rows);
        ASSERT_EQ(scanned, expected);
        ASSERT_EQ(blocked.NearestWith(*kernels, queries[query]),
                  static_cast<size_t>(std::min_element(expected.begin(), expected.end()) -
                                      expected.begin()));
        for (const size_t num_parts : {1u, 2u, 7u}) {
          ASSERT_EQ(MinimaOf(blocked, *kernels, queries[query], num_parts),
                    scene.ExpectedMinima(query, num_parts));
        }
        for (const int32_t bound : {expected[num_rows / 2], Scene::kNone}) {
          for (const size_t begin : {size_t{0}, num_rows / 3, num_rows - 1}) {
            const size_t end = num_rows - num_rows / 5;
            EXPECT_THAT(RangeOf(blocked, *kernels, queries[query], begin, end, bound),
                        ElementsAreArray(ExpectedRange(expected, begin, end, bound)));
          }
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Strides, BlockKernelsTest,
                         ::testing::Combine(::testing::Values(16, 32, 128),
                                            ::testing::Values(kRowCenter, uint8_t{63})));

// Of these rows, a level 1 cache holds several parts.
TEST(BlockedRows, ScansSeveralQueriesAsOneByOne) {
  constexpr size_t kNumRows = 1000;
  const Scene scene(128, kNumRows, 3);
  const BlockedRows blocked(scene.rows.data(), 128, scene.order);
  const BlockQueries queries(scene.steps, blocked.centers());
  constexpr size_t kBegin = 2, kEnd = 7;
  std::vector<int32_t> scanned((kEnd - kBegin) * blocked.padded_size());
  blocked.Scan(queries, kBegin, kEnd, scanned.data());
  for (size_t query = kBegin; query < kEnd; ++query) {
    const auto begin =
        scanned.begin() + static_cast<ptrdiff_t>((query - kBegin) * blocked.padded_size());
    EXPECT_EQ(std::vector<int32_t>(begin, begin + kNumRows),
              scene.Expected(static_cast<int>(query)));
  }
}

TEST(BlockedRows, NearestOfEqualRowsIsTheFirst) {
  const std::vector<uint8_t> rows(40 * 16, 7);
  std::vector<uint32_t> order(40);
  std::iota(order.begin(), order.end(), 0u);
  const BlockedRows blocked(rows.data(), 16, order);
  const BlockQueries queries(std::vector<int16_t>(16, 9), blocked.centers());
  for (const BlockKernels* kernels : SupportedBlockKernels()) {
    EXPECT_EQ(blocked.NearestWith(*kernels, queries[0]), 0u) << kernels->name;
  }
}

TEST(BlockedRows, NearestAreThoseOfASort) {
  for (const size_t num_rows : {1u, 17u, 100u, 500u}) {
    const Scene scene(16, num_rows, num_rows);
    const BlockedRows blocked(scene.rows.data(), 16, scene.order);
    const BlockQueries queries(scene.steps, blocked.centers());
    NearestScratch scratch;
    for (int query = 0; query < Scene::kNumQueries; ++query) {
      std::vector<std::pair<int32_t, uint32_t>> expected;
      for (const int32_t sq_distance : scene.Expected(query)) {
        expected.emplace_back(sq_distance, expected.size());
      }
      std::sort(expected.begin(), expected.end());
      for (const size_t count : {size_t{0}, size_t{1}, num_rows / 2, num_rows}) {
        std::vector<BlockHit> nearest = {{7, 7}};
        blocked.Nearest(queries[query], count, &scratch, &nearest);
        ASSERT_EQ(nearest.size(), count + 1);
        EXPECT_EQ(nearest[0].row, 7u);  // Appended.
        std::vector<std::pair<int32_t, uint32_t>> found;
        for (size_t i = 1; i < nearest.size(); ++i) {
          found.emplace_back(nearest[i].sq_distance, nearest[i].row);
        }
        std::sort(found.begin(), found.end());
        EXPECT_TRUE(std::equal(found.begin(), found.end(), expected.begin()));
      }
    }
  }
}

// Rows of all 255 overflow 16 bits within 4,112 of them.
TEST(BlockedRows, SumAnyRun) {
  constexpr int kStride = 32;
  constexpr size_t kNumRows = 9'000;
  Scene scene(kStride, kNumRows, 3);
  std::fill(scene.rows.begin(), scene.rows.begin() + 5'000 * kStride, uint8_t{255});
  std::iota(scene.order.begin(), scene.order.end(), 0u);
  const BlockedRows blocked(scene.rows.data(), kStride, scene.order);
  for (const auto& [begin, end] : std::vector<std::pair<size_t, size_t>>{
           {0, 0}, {0, 1}, {15, 17}, {16, 32}, {3, 16}, {0, kNumRows}, {7, 8'999}}) {
    std::vector<uint32_t> sums(kStride, 77), expected(kStride, 0);
    blocked.Sum(begin, end, sums.data());
    for (size_t i = begin * kStride; i < end * kStride; ++i) {
      expected[i % kStride] += scene.rows[i];
    }
    EXPECT_EQ(sums, expected) << begin << " to " << end;
  }
}

TEST(BlockedRows, OfCodesAreThoseOfTheirBytes) {
  const Codebook codebook = testing::RandomCodebook();
  const ByteScale scale(codebook);
  std::mt19937_64 random(5);
  std::vector<uint8_t> codes(100 * size_t{8});
  std::generate(codes.begin(), codes.end(), [&] { return static_cast<uint8_t>(random()); });
  std::vector<uint32_t> order(100);
  std::iota(order.begin(), order.end(), 0u);
  const BlockedRows expected(scale.ExpandCodes(codebook, codes).data(), scale.stride(), order);
  const BlockedRows blocked(CodeWords(codebook, scale), codes);
  ASSERT_EQ(blocked.padded_size(), 112u);
  const Scene scene(scale.stride(), 1, 6);
  const BlockQueries queries(scene.steps, blocked.centers());
  for (size_t query = 0; query < queries.size(); ++query) {
    std::vector<int32_t> distances(112), expected_distances(112);
    blocked.Scan(queries[query], distances.data());
    expected.Scan(queries[query], expected_distances.data());
    EXPECT_EQ(distances, expected_distances) << query;
  }
}

// More rows than are expanded at once, some of them twice.
TEST(BlockedRows, OfCodesTakeAnyOrder) {
  const Codebook codebook = testing::RandomCodebook();
  const ByteScale scale(codebook);
  constexpr size_t kNumRows = 9'000;
  std::mt19937_64 random(8);
  std::vector<uint8_t> codes(kNumRows * size_t{8});
  std::generate(codes.begin(), codes.end(), [&] { return static_cast<uint8_t>(random()); });
  std::vector<uint32_t> order(kNumRows);
  std::generate(order.begin(), order.end(),
                [&] { return static_cast<uint32_t>(random() % kNumRows); });
  const BlockedRows expected(scale.ExpandCodes(codebook, codes).data(), scale.stride(), order);
  const BlockedRows blocked(CodeWords(codebook, scale), codes, order);
  const Scene scene(scale.stride(), 1, 6);
  const BlockQueries queries(scene.steps, blocked.centers());
  std::vector<int32_t> distances(blocked.padded_size()), expected_distances(blocked.padded_size());
  blocked.Scan(queries[0], distances.data());
  expected.Scan(queries[0], expected_distances.data());
  EXPECT_EQ(distances, expected_distances);
}

// Runs that are empty, end within a block, and are longer than what is expanded at once.
TEST(BlockedRows, OfCodesSumTheirRuns) {
  const Codebook codebook = testing::RandomCodebook();
  const ByteScale scale(codebook);
  std::mt19937_64 random(7);
  std::vector<uint8_t> codes(15'000 * size_t{8});
  std::generate(codes.begin(), codes.end(), [&] { return static_cast<uint8_t>(random()); });
  const std::vector<uint32_t> begin = {0, 0, 5, 4'095, 4'097, 4'112, 14'000, 14'000, 15'000};
  std::vector<uint32_t> sums;
  const BlockedRows blocked(CodeWords(codebook, scale), codes, begin, &sums);
  const size_t stride = scale.stride();
  const std::vector<uint8_t> rows = scale.ExpandCodes(codebook, codes);
  std::vector<uint32_t> expected((begin.size() - 1) * stride, 0);
  for (size_t run = 0; run + 1 < begin.size(); ++run) {
    for (size_t i = begin[run] * stride; i < begin[run + 1] * stride; ++i) {
      expected[run * stride + i % stride] += rows[i];
    }
  }
  EXPECT_EQ(sums, expected);
}

TEST(BlockedRows, HoldNothing) {
  const BlockedRows blocked(nullptr, 16, {});
  EXPECT_EQ(blocked.size(), 0u);
  const BlockQueries queries(std::vector<int16_t>(16, 9), blocked.centers());
  EXPECT_EQ(blocked.Range(queries[0], 0, 0, std::numeric_limits<int32_t>::max(), nullptr), 0u);
}

// The largest products of narrow pairs, which must not saturate.
class NarrowPairs : public ::testing::TestWithParam<int> {};

TEST_P(NarrowPairs, OfExtremeBytesAreExact) {
  const int stride = GetParam();
  std::vector<uint8_t> rows(size_t{2} * stride, 255);
  std::fill_n(rows.begin(), stride, uint8_t{0});
  const BlockedRows blocked(rows.data(), stride, std::vector<uint32_t>{0, 1});
  for (const auto& [even, odd] : std::vector<std::pair<int, int>>{
           {127, 0}, {0, 127}, {64, 63}, {-127, 0}, {-64, -63}, {127, -127}}) {
    std::vector<int16_t> steps;
    for (int dim = 0; dim < stride; ++dim) {
      steps.push_back(static_cast<int16_t>(128 + (dim % 2 == 0 ? even : odd)));
    }
    const BlockQueries queries(steps, blocked.centers());
    EXPECT_TRUE(queries[0].has_narrow_pairs) << even << " " << odd;
    for (const BlockKernels* kernels : SupportedBlockKernels()) {
      std::vector<int32_t> scanned(blocked.padded_size());
      blocked.ScanWith(*kernels, queries[0], scanned.data());
      for (int row = 0; row < 2; ++row) {
        const int a = steps[0] - 255 * row, b = steps[1] - 255 * row;
        EXPECT_EQ(scanned[row], stride / 2 * (a * a + b * b)) << kernels->name;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Strides, NarrowPairs, ::testing::Values(16, 128));

TEST(BlockQueries, KnowWhetherTheirPairsAreNarrow) {
  const std::vector<int16_t> centers(16, 128);
  for (const auto& [even, odd] :
       std::vector<std::pair<int, int>>{{128, 0}, {64, 64}, {-128, 0}, {-64, -64}, {0, -300}}) {
    std::vector<int16_t> steps(16, 128);
    steps[14] = static_cast<int16_t>(128 + even);
    steps[15] = static_cast<int16_t>(128 + odd);
    EXPECT_FALSE(BlockQueries(steps, centers)[0].has_narrow_pairs) << even << " " << odd;
  }
}

TEST(BlockQueries, NeedOnePartWithinTheRowsRange) {
  const std::vector<int16_t> centers(16, 128);
  EXPECT_EQ(BlockQueries(std::vector<int16_t>(16, 0), centers)[0].num_parts, 1);
  EXPECT_EQ(BlockQueries(std::vector<int16_t>(16, 255), centers)[0].num_parts, 1);
  EXPECT_EQ(BlockQueries(std::vector<int16_t>(16, 256), centers)[0].num_parts, 2);
}

}  // namespace
}  // namespace cairn
