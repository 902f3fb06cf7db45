#include "engine/matching/blocked_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include "engine/matching/distance_kernels.h"

namespace cairn {
namespace {

// Random rows and queries; some queries reach far beyond the rows.
struct Scene {
  Scene(int stride_in, size_t num_rows, uint64_t seed)
      : stride(stride_in), rows(num_rows * stride) {
    std::mt19937_64 random(seed);
    for (uint8_t& value : rows) {
      value = static_cast<uint8_t>(random() % 256);
    }
    for (int query = 0; query < kNumQueries; ++query) {
      const int reach = query % 3 == 0 ? 1024 : query % 3 == 1 ? 300 : 0;
      for (int dim = 0; dim < stride; ++dim) {
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
    std::vector<int32_t> sq_distances(order.size());
    SupportedDistanceKernels().front()->gather(steps.data() + query * stride, rows.data(), stride,
                                               order.data(), order.size(), sq_distances.data());
    return sq_distances;
  }

  static constexpr int kNumQueries = 12;
  int stride;
  std::vector<uint8_t> rows;
  std::vector<int16_t> steps;
  std::vector<uint32_t> order;
};

class BlockKernelsTest : public ::testing::TestWithParam<int> {};

// Every variant against plain distances row by row, as the variant would be used by BlockedRows.
TEST_P(BlockKernelsTest, EveryVariantGivesTheSame) {
  const int stride = GetParam();
  for (const size_t num_rows : {1u, 15u, 16u, 17u, 100u}) {
    const Scene scene(stride, num_rows, num_rows);
    const BlockedRows blocked(scene.rows.data(), stride, scene.order);
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
        for (const size_t count : {size_t{1}, (num_rows + 1) / 2, num_rows}) {
          std::vector<int32_t> sorted = expected;
          std::sort(sorted.begin(), sorted.end());
          const int32_t at_least = blocked.BoundWith(*kernels, queries[query], count);
          ASSERT_GE(at_least, sorted[count - 1]);
          ASSERT_EQ(at_least,
                    blocked.BoundWith(*SupportedBlockKernels().front(), queries[query], count));
        }
        const int32_t bound = expected[num_rows / 2];
        for (const size_t begin : {size_t{0}, num_rows / 3, num_rows - 1}) {
          std::vector<BlockHit> hits(num_rows);
          hits.resize(blocked.RangeWith(*kernels, queries[query], begin, num_rows - num_rows / 5,
                                        bound, hits.data()));
          size_t next = 0;
          for (size_t row = begin; row < num_rows - num_rows / 5; ++row) {
            if (expected[row] <= bound) {
              ASSERT_LT(next, hits.size());
              ASSERT_EQ(hits[next].row, row);
              ASSERT_EQ(hits[next++].sq_distance, expected[row]);
            }
          }
          ASSERT_EQ(next, hits.size());
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Strides, BlockKernelsTest, ::testing::Values(16, 32, 128));

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

TEST(BlockedRows, BoundIsTightWhereRowsAreMany) {
  constexpr size_t kNumRows = 1'024;
  constexpr size_t kCount = 20;
  const Scene scene(16, kNumRows, 1);
  const BlockedRows blocked(scene.rows.data(), 16, scene.order);
  const BlockQueries queries(scene.steps, blocked.centers());
  for (int query = 0; query < Scene::kNumQueries; ++query) {
    std::vector<int32_t> sorted = scene.Expected(query);
    std::sort(sorted.begin(), sorted.end());
    EXPECT_LE(blocked.BoundWith(BestBlockKernels(), queries[query], kCount), sorted[300]);
  }
}

TEST(BlockedRows, NearestAreThoseOfASort) {
  for (const size_t num_rows : {1u, 17u, 100u, 500u}) {
    const Scene scene(16, num_rows, num_rows);
    const BlockedRows blocked(scene.rows.data(), 16, scene.order);
    const BlockQueries queries(scene.steps, blocked.centers());
    for (int query = 0; query < Scene::kNumQueries; ++query) {
      std::vector<std::pair<int32_t, uint32_t>> expected;
      for (const int32_t sq_distance : scene.Expected(query)) {
        expected.emplace_back(sq_distance, expected.size());
      }
      std::sort(expected.begin(), expected.end());
      for (const size_t count : {size_t{0}, size_t{1}, num_rows / 2, num_rows}) {
        std::vector<BlockHit> hits, nearest = {{7, 7}};
        blocked.Nearest(queries[query], count, &hits, &nearest);
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

TEST(BlockedRows, HoldNothing) {
  const BlockedRows blocked(nullptr, 16, {});
  EXPECT_EQ(blocked.size(), 0u);
  const BlockQueries queries(std::vector<int16_t>(16, 9), blocked.centers());
  EXPECT_EQ(blocked.Range(queries[0], 0, 0, std::numeric_limits<int32_t>::max(), nullptr), 0u);
}

TEST(BlockQueries, NeedOnePartWithinTheRowsRange) {
  const std::vector<int16_t> centers(16, 128);
  EXPECT_EQ(BlockQueries(std::vector<int16_t>(16, 0), centers)[0].num_parts, 1);
  EXPECT_EQ(BlockQueries(std::vector<int16_t>(16, 255), centers)[0].num_parts, 1);
  EXPECT_EQ(BlockQueries(std::vector<int16_t>(16, 256), centers)[0].num_parts, 2);
}

}  // namespace
}  // namespace cairn
