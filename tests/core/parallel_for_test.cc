#include "core/parallel_for.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace cairn {
namespace {

TEST(ParallelFor, RunsEachStepOnce) {
  for (const int num_threads : {1, 2, 7}) {
    std::vector<std::atomic<int>> counts(100);
    ParallelFor(100, num_threads, [&](int i) { ++counts[i]; });
    for (const std::atomic<int>& count : counts) {
      EXPECT_EQ(count, 1);
    }
  }
}

TEST(ParallelFor, DoesNothingForNoSteps) {
  ParallelFor(0, 4, [](int) { FAIL(); });
}

TEST(ParallelFor, PassesOnAnException) {
  EXPECT_THROW(ParallelFor(50, 3,
                           [](int i) {
                             if (i == 20) {
                               throw std::runtime_error("step 20");
                             }
                           }),
               std::runtime_error);
}

}  // namespace
}  // namespace cairn
