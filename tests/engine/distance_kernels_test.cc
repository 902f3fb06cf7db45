#include "engine/index/distance_kernels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

namespace cairn {
namespace {

struct KernelInput {
  std::vector<int16_t> query;
  std::vector<uint8_t> rows;
};

KernelInput RandomInput(int stride, size_t count) {
  std::mt19937_64 random(stride * 1000 + count);
  KernelInput input;
  for (int i = 0; i < stride; ++i) {
    input.query.push_back(static_cast<int16_t>(static_cast<int>(random() % 2304) - 1024));
  }
  for (size_t i = 0; i < count * stride; ++i) {
    input.rows.push_back(static_cast<uint8_t>(random()));
  }
  return input;
}

int32_t SqDistance(const KernelInput& input, int stride, uint32_t row) {
  int32_t sum = 0;
  for (int j = 0; j < stride; ++j) {
    const int32_t difference = input.query[j] - input.rows[size_t{row} * stride + j];
    sum += difference * difference;
  }
  return sum;
}

TEST(DistanceKernels, EveryVariantGivesTheDefinitionExactly) {
  for (const DistanceKernels* kernels : SupportedDistanceKernels()) {
    for (const int stride : {16, 32, 48, 128}) {
      for (const size_t count : {0, 1, 3, 4, 5, 64, 203}) {
        SCOPED_TRACE(std::string(kernels->name) + " stride " + std::to_string(stride) + " count " +
                     std::to_string(count));
        const KernelInput input = RandomInput(stride, count);
        std::vector<int32_t> scanned(count), expected;
        kernels->scan(input.query.data(), input.rows.data(), stride, count, scanned.data());
        for (size_t i = 0; i < count; ++i) {
          expected.push_back(SqDistance(input, stride, static_cast<uint32_t>(i)));
        }
        EXPECT_EQ(scanned, expected);
      }
    }
  }
}

TEST(DistanceKernels, LargestDistanceDoesNotOverflow) {
  const std::vector<int16_t> query(kMaxDistanceStride, -1024);
  const std::vector<uint8_t> rows(4 * kMaxDistanceStride, 255);
  for (const DistanceKernels* kernels : SupportedDistanceKernels()) {
    std::vector<int32_t> sq_distances(4);
    kernels->scan(query.data(), rows.data(), kMaxDistanceStride, 4, sq_distances.data());
    EXPECT_THAT(sq_distances, ::testing::Each(1279 * 1279 * kMaxDistanceStride)) << kernels->name;
  }
}

TEST(DistanceKernels, PortableVariantIsAlwaysThereAndTheBestOneIsSupported) {
  const auto supported = SupportedDistanceKernels();
  EXPECT_STREQ(supported.front()->name, "plain");
  EXPECT_THAT(supported, ::testing::Contains(&BestDistanceKernels()));
}

}  // namespace
}  // namespace cairn
