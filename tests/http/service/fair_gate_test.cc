#include "http/service/fair_gate.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace cairn {
namespace {

using Clock = std::chrono::steady_clock;

const Clock::time_point kNever = Clock::now() + std::chrono::hours(1);

TEST(FairGate, LetsAsManyInAsThereAreSlots) {
  FairGate gate(2);
  EXPECT_TRUE(gate.Enter(kNever));
  EXPECT_TRUE(gate.Enter(kNever));
  EXPECT_FALSE(gate.Enter(Clock::now()));  // Full, and no time to wait.
  gate.Leave();
  EXPECT_TRUE(gate.Enter(Clock::now()));
}

TEST(FairGate, ServesInOrderOfArrival) {
  constexpr int kNumThreads = 6;
  FairGate gate(1);
  ASSERT_TRUE(gate.Enter(kNever));
  std::vector<int> order;  // Guarded by the gate's only slot.
  std::vector<std::thread> threads;
  for (int i = 0; i < kNumThreads; ++i) {
    threads.emplace_back([&gate, &order, i] {
      ASSERT_TRUE(gate.Enter(kNever));
      order.push_back(i);
      gate.Leave();
    });
    while (gate.num_waiting() <= i) {
      std::this_thread::yield();
    }
  }
  gate.Leave();
  for (std::thread& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(order, (std::vector<int>{0, 1, 2, 3, 4, 5}));
}

TEST(FairGate, WhoGivesUpLosesItsPlaceOnly) {
  FairGate gate(1);
  ASSERT_TRUE(gate.Enter(kNever));
  EXPECT_FALSE(gate.Enter(Clock::now()));
  EXPECT_EQ(gate.num_waiting(), 0);
  std::atomic<bool> entered{false};
  std::thread patient([&] {
    entered = gate.Enter(kNever);
    gate.Leave();
  });
  while (gate.num_waiting() == 0) {
    std::this_thread::yield();
  }
  EXPECT_FALSE(gate.Enter(Clock::now()));
  gate.Leave();
  patient.join();
  EXPECT_TRUE(entered);
  EXPECT_TRUE(gate.Enter(Clock::now()));  // The slot is free again.
}

}  // namespace
}  // namespace cairn
