#include "engine/matching/cell_sketch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace cairn {
namespace {

int32_t QuarterOf(uint32_t sketch, int dim) {
  return static_cast<int32_t>(sketch >> (2 * dim) & 3);
}

// By the definition: the squared distance to the middles of the sketch's quarters of the cell that
// begins at `origin`.
int64_t SumByDefinition(uint32_t sketch, const std::vector<int32_t>& coordinates,
                        const std::vector<int32_t>& origin) {
  int64_t sum = 0;
  for (int dim = 0; dim < std::min(static_cast<int>(coordinates.size()), kSketchDims); ++dim) {
    const int64_t distance = origin[dim] + 64 * QuarterOf(sketch, dim) + 32 - coordinates[dim];
    sum += distance * distance;
  }
  return sum;
}

int64_t SumByTable(uint32_t sketch, const SketchTable& table, int num_pairs) {
  int64_t sum = 0;
  for (int pair = 0; pair < num_pairs; ++pair) {
    sum += table.sq_distances[pair * kSketchEntries + (sketch >> (4 * pair)) % 16];
  }
  return sum;
}

std::vector<int32_t> RandomCoordinates(int count, std::mt19937_64* random) {
  std::uniform_int_distribution<int32_t> uniform(-100'000, 100'000);
  std::vector<int32_t> coordinates;
  for (int i = 0; i < count; ++i) {
    coordinates.push_back(uniform(*random));
  }
  return coordinates;
}

// Bits of dimensions that do not exist are 0.
uint32_t RandomSketch(int num_dims, std::mt19937_64* random) {
  const auto bits = static_cast<uint32_t>((*random)());
  return num_dims < kSketchDims ? bits & ((uint32_t{1} << (2 * num_dims)) - 1) : bits;
}

TEST(SketchTables, HoldDistancesToTheMiddlesOfQuarters) {
  std::mt19937_64 random(1);
  for (const int num_dims : {1, 2, 5, 12, 16, 40}) {
    for (int i = 0; i < 50; ++i) {
      const std::vector<int32_t> coordinates = RandomCoordinates(num_dims, &random);
      SketchTables tables;
      tables.SetQuery(coordinates);
      const uint32_t dims_mask = num_dims < 16 ? (1u << num_dims) - 1 : 0xFFFF;
      const uint32_t crossed = i == 0 ? 0 : static_cast<uint32_t>(random()) & dims_mask;
      std::vector<int32_t> origin;
      for (int dim = 0; dim < num_dims; ++dim) {
        const auto begin = static_cast<int32_t>(std::floor(coordinates[dim] / 256.0)) * 256;
        const int32_t next = coordinates[dim] - begin < 128 ? begin - 256 : begin + 256;
        origin.push_back(dim < kSketchDims && (crossed >> dim & 1) != 0 ? next : begin);
      }
      const SketchTable& table = tables.Across(crossed);
      for (int j = 0; j < 20; ++j) {
        const uint32_t sketch = RandomSketch(num_dims, &random);
        EXPECT_EQ(SumByTable(sketch, table, tables.num_pairs()),
                  SumByDefinition(sketch, coordinates, origin))
            << num_dims << " dimensions, crossed " << crossed;
      }
    }
  }
}

TEST(SketchKernels, EveryVariantKeepsWhatTheDefinitionDoes) {
  std::mt19937_64 random(2);
  for (const SketchKernels* kernels : SupportedSketchKernels()) {
    for (const int num_dims : {1, 4, 12, 16}) {
      for (const size_t count : {0, 1, 7, 8, 9, 16, 17, 31, 100, 400}) {
        SCOPED_TRACE(std::string(kernels->name) + ", " + std::to_string(num_dims) +
                     " dimensions, " + std::to_string(count) + " items");
        SketchTables tables;
        tables.SetQuery(RandomCoordinates(num_dims, &random));
        const SketchTable& table = tables.Across(random() & 1);
        std::vector<uint32_t> sketches, items, expected;
        const int32_t max_sum = 6'000 * num_dims;
        for (size_t i = 0; i < count; ++i) {
          sketches.push_back(RandomSketch(num_dims, &random));
          items.push_back(static_cast<uint32_t>(random()));
          if (SumByTable(sketches[i], table, tables.num_pairs()) <= max_sum) {
            expected.push_back(items[i]);
          }
        }
        std::vector<uint32_t> kept(count + kSketchSlack);
        kept.resize(kernels->filter(table, tables.num_pairs(), max_sum, sketches.data(),
                                    items.data(), count, kept.data()));
        EXPECT_EQ(kept, expected);
      }
    }
  }
}

// Share of random descriptors at a distance from a query, in any of the cells, whose sum is within
// the limit for `max_distance`.
double KeptShare(double distance, double max_distance, int num_dims) {
  constexpr int kNumTrials = 4'000;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  int num_kept = 0;
  for (int i = 0; i < kNumTrials; ++i) {
    const std::vector<int32_t> coordinates = RandomCoordinates(num_dims, &random);
    std::vector<double> step(num_dims);
    double sq_length = 0.0;
    for (double& value : step) {
      value = normal(random);
      sq_length += value * value;
    }
    uint32_t sketch = 0;
    std::vector<int32_t> origin;
    for (int dim = 0; dim < num_dims; ++dim) {
      const double place = coordinates[dim] + step[dim] * distance / std::sqrt(sq_length);
      const auto floor = static_cast<int32_t>(std::floor(place));
      sketch |= static_cast<uint32_t>((floor & 255) / 64) << (2 * dim);
      origin.push_back(floor - (floor & 255));
    }
    const int64_t sum = SumByDefinition(sketch, coordinates, origin);
    num_kept += sum <= MaxSketchSum(max_distance * max_distance, num_dims) ? 1 : 0;
  }
  return num_kept / static_cast<double>(kNumTrials);
}

TEST(MaxSketchSum, KeepsWhatIsNearAndRefusesWhatIsFar) {
  for (const int num_dims : {4, 12, 16}) {
    const double reach = 60.0 * std::sqrt(num_dims);  // Of a quarter a dimension.
    EXPECT_GT(KeptShare(0.8 * reach, reach, num_dims), 0.8);
    EXPECT_GT(KeptShare(reach, reach, num_dims), 0.2);
    EXPECT_LT(KeptShare(2.0 * reach, reach, num_dims), 0.05);
  }
}

TEST(MaxSketchSum, KeepsWhatIsMuchNearerThanAQuarterIsWide) {
  for (const int num_dims : {1, 4, 12, 16}) {
    EXPECT_EQ(KeptShare(0.0, 0.0, num_dims), 1.0);
    EXPECT_GT(KeptShare(1.0, 2.0, num_dims), 0.97);
  }
}

TEST(MaxSketchSum, IsNotExceededByFarLimits) {
  EXPECT_GT(MaxSketchSum(1e30, 12), 16 * 448 * 448);  // More than a sketch's sum can be.
}

}  // namespace
}  // namespace cairn
