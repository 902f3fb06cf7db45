#include "core/large_vector.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>

namespace cairn {
namespace {

// Below, around and above the sizes from which on huge pages are taken.
TEST(LargeVector, HoldsWhatIsWrittenAtAnySize) {
  constexpr size_t kMegabyte = size_t{1} << 20;
  for (const size_t size : {size_t{0}, size_t{1}, kMegabyte - 1, kMegabyte, 2 * kMegabyte,
                            3 * kMegabyte - 1, 3 * kMegabyte, 5 * kMegabyte + 3}) {
    LargeVector<uint8_t> bytes(size);
    std::iota(bytes.begin(), bytes.end(), uint8_t{0});
    EXPECT_EQ(reinterpret_cast<uintptr_t>(bytes.data()) % 64, 0u);
    bytes.resize(size + 1);
    bytes.back() = 7;
    size_t num_wrong = 0;
    for (size_t i = 0; i < size; ++i) {
      num_wrong += bytes[i] != static_cast<uint8_t>(i) ? 1 : 0;
    }
    EXPECT_EQ(num_wrong, 0u) << size;
    EXPECT_EQ(bytes.back(), 7);
  }
}

TEST(LargeVector, FillsWithAGivenValue) {
  EXPECT_EQ(LargeVector<uint32_t>(3, 0), (LargeVector<uint32_t>{0, 0, 0}));
}

}  // namespace
}  // namespace cairn
