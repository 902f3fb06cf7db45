#include "core/large_vector.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <numeric>
#include <thread>
#include <vector>

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

// What grows within a block of pages is as large as what was freed.
TEST(LargeVector, BlocksAreUsedAgainAtAnySizeOfAsManyPages) {
  constexpr size_t kMegabyte = size_t{1} << 20;
  for (int round = 0; round < 3; ++round) {
    for (const size_t size : {kMegabyte, 3 * kMegabyte - 1, 3 * kMegabyte, 2 * kMegabyte}) {
      LargeVector<uint8_t> bytes(size);
      EXPECT_EQ(reinterpret_cast<uintptr_t>(bytes.data()) % 64, 0u);
      std::fill(bytes.begin(), bytes.end(), static_cast<uint8_t>(round));
      EXPECT_EQ(std::count(bytes.begin(), bytes.end(), static_cast<uint8_t>(round)),
                static_cast<ptrdiff_t>(size));
    }
  }
}

#if !defined(__SANITIZE_ADDRESS__)
TEST(LargeVector, ABlockWaitsForTheNextOfItsSize) {
  constexpr size_t kSize = size_t{14} << 20;  // Of no other test.
  const uint8_t* first = LargeVector<uint8_t>(kSize).data();
  const LargeVector<uint8_t> other(2 * kSize);
  EXPECT_EQ(LargeVector<uint8_t>(kSize + 1).data(), first);
}
#endif

// More than is kept, from several threads; each block belongs to one vector at a time.
TEST(LargeVector, ThreadsShareFreedBlocks) {
  std::atomic<int> num_wrong = 0;
  const auto work = [&num_wrong](uint32_t mark) {
    for (int round = 0; round < 20; ++round) {
      std::vector<LargeVector<uint32_t>> vectors;
      for (size_t i = 0; i < 12; ++i) {
        vectors.emplace_back((1 + i % 5) << 19);  // 2 to 10 MB.
        vectors.back().front() = vectors.back().back() = mark;
      }
      for (const LargeVector<uint32_t>& vector : vectors) {
        num_wrong += vector.front() == mark && vector.back() == mark ? 0 : 1;
      }
    }
  };
  std::vector<std::thread> threads;
  for (uint32_t mark = 0; mark < 4; ++mark) {
    threads.emplace_back(work, mark);
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(num_wrong, 0);
}

TEST(LargeVector, FillsWithAGivenValue) {
  EXPECT_EQ(LargeVector<uint32_t>(3, 0), (LargeVector<uint32_t>{0, 0, 0}));
}

}  // namespace
}  // namespace cairn
