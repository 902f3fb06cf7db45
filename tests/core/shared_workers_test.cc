#include "core/shared_workers.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <stdexcept>
#include <thread>
#include <vector>

namespace cairn {
namespace {

TEST(SharedWorkers, RunsEachStepOnce) {
  for (const int num_threads : {1, 2, 5}) {
    SharedWorkers workers(num_threads);
    const SharedWorkers::Caller caller(&workers);
    for (const int count : {0, 1, 2, 100}) {
      std::vector<std::atomic<int>> runs(count);
      workers.ForEach(count, [&](int i) { ++runs[i]; });
      for (const auto& run : runs) {
        EXPECT_EQ(run, 1);
      }
    }
  }
}

TEST(SharedWorkers, HelpsACallerThatIsAlone) {
  SharedWorkers workers(3);
  const SharedWorkers::Caller caller(&workers);
  std::latch all_three(3);  // Nobody passes before three threads have come.
  workers.ForEach(3, [&](int) { all_three.arrive_and_wait(); });
  EXPECT_TRUE(all_three.try_wait());
}

TEST(SharedWorkers, LeavesEachCallerACore) {
  SharedWorkers workers(2);
  const SharedWorkers::Caller first(&workers), second(&workers);
  const std::thread::id own = std::this_thread::get_id();
  std::atomic<int> num_elsewhere{0};
  workers.ForEach(200, [&](int) { num_elsewhere += std::this_thread::get_id() != own; });
  EXPECT_EQ(num_elsewhere, 0);
}

TEST(SharedWorkers, HelpsAgainWhenTheOtherCallerHasLeft) {
  SharedWorkers workers(2);
  const SharedWorkers::Caller first(&workers);
  { const SharedWorkers::Caller second(&workers); }
  std::latch both(2);
  workers.ForEach(2, [&](int) { both.arrive_and_wait(); });
  EXPECT_TRUE(both.try_wait());
}

TEST(SharedWorkers, ServesManyCallersAtOnce) {
  constexpr int kNumCallers = 8;
  SharedWorkers workers(4);
  std::atomic<int> sum{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < kNumCallers; ++t) {
    threads.emplace_back([&] {
      const SharedWorkers::Caller caller(&workers);
      for (int repeat = 0; repeat < 50; ++repeat) {
        workers.ForEach(7, [&](int i) { sum += i; });
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(sum, kNumCallers * 50 * 21);
}

TEST(SharedWorkers, ThrowsWhatAStepThrew) {
  for (const int num_threads : {1, 4}) {
    SharedWorkers workers(num_threads);
    const SharedWorkers::Caller caller(&workers);
    EXPECT_THROW(workers.ForEach(20,
                                 [](int i) {
                                   if (i == 3) {
                                     throw std::runtime_error("step 3");
                                   }
                                 }),
                 std::runtime_error);
    std::atomic<int> num_runs{0};
    workers.ForEach(5, [&](int) { ++num_runs; });  // Still of use.
    EXPECT_EQ(num_runs, 5);
  }
}

TEST(SharedWorkers, ThrowsTheExceptionOfTheFirstStepThatThrew) {
  SharedWorkers workers(2);
  const SharedWorkers::Caller caller(&workers);
  for (int repeat = 0; repeat < 20; ++repeat) {
    std::latch second_throws(1);
    const auto step = [&](int i) {
      if (i == 0) {
        second_throws.wait();
      } else {
        second_throws.count_down();
      }
      throw i;
    };
    try {
      workers.ForEach(2, step);
      FAIL() << "no exception";
    } catch (int thrown_by) {
      EXPECT_EQ(thrown_by, 0);
    }
  }
}

}  // namespace
}  // namespace cairn
