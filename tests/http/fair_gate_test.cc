#include "http/service/fair_gate.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

namespace cairn {
namespace {

using Clock = FairGate::Clock;
using Outcome = FairGate::Outcome;
using Turn = FairGate::Turn;
using std::chrono::hours;
using std::chrono::milliseconds;

const Clock::time_point kNever = Clock::now() + hours(1);
constexpr FairGate::ClientId kAttacker = 1, kGood = 2, kOther = 3;

// In these gates, no turn is long unless a test says so.
FairGateOptions Slots(int num_slots) {
  return {.num_slots = num_slots, .max_waiting = 100, .patience = hours(1)};
}

std::unique_ptr<Turn> Enter(FairGate* gate, FairGate::ClientId client,
                            Clock::time_point deadline = kNever) {
  return std::make_unique<Turn>(gate, client, deadline);
}

// Threads that wait at a gate, in the order of Add.
class Waiters {
 public:
  explicit Waiters(FairGate* gate) : gate_(gate) {}
  ~Waiters() { Join(); }

  // Returns when the thread waits. `number` identifies it in order().
  void Add(FairGate::ClientId client, int number, Clock::time_point deadline = kNever) {
    const int before = gate_->num_waiting();
    threads_.emplace_back([this, client, number, deadline] {
      const Turn turn(gate_, client, deadline);
      if (turn.outcome() == Outcome::kEntered) {
        order_.push_back(number);  // Guarded by the gate's only slot.
      } else {
        refused_ = number;
      }
    });
    while (gate_->num_waiting() == before && refused_ < 0) {
      std::this_thread::yield();
    }
  }
  void Join() {
    for (std::thread& thread : threads_) {
      thread.join();
    }
    threads_.clear();
  }
  const std::vector<int>& order() const { return order_; }
  int refused() const { return refused_; }

 private:
  FairGate* gate_;
  std::vector<std::thread> threads_;
  std::vector<int> order_;
  std::atomic<int> refused_{-1};
};

TEST(FairGate, LetsAsManyInAsThereAreSlots) {
  FairGate gate(Slots(2));
  const auto first = Enter(&gate, kGood);
  auto second = Enter(&gate, kGood);
  EXPECT_EQ(first->outcome(), Outcome::kEntered);
  EXPECT_EQ(second->outcome(), Outcome::kEntered);
  EXPECT_EQ(Enter(&gate, kGood, Clock::now())->outcome(), Outcome::kLate);
  second.reset();
  EXPECT_EQ(Enter(&gate, kGood, Clock::now())->outcome(), Outcome::kEntered);
}

TEST(FairGate, ServesAClientInOrderOfArrival) {
  FairGate gate(Slots(1));
  Waiters waiters(&gate);
  {
    const Turn turn(&gate, kGood, kNever);
    for (int i = 0; i < 6; ++i) {
      waiters.Add(kGood, i);
    }
  }
  waiters.Join();
  EXPECT_EQ(waiters.order(), (std::vector<int>{0, 1, 2, 3, 4, 5}));
}

// Who can wait for a minute lets those pass who cannot.
TEST(FairGate, AClientsRequestsWithEarlierDeadlinesComeFirst) {
  FairGate gate(Slots(1));
  Waiters waiters(&gate);
  {
    const Turn turn(&gate, kGood, kNever);
    waiters.Add(kGood, 0, kNever + hours(2));
    waiters.Add(kGood, 1, kNever + hours(2));
    waiters.Add(kGood, 2, kNever);
    waiters.Add(kGood, 3, kNever + hours(1));
    waiters.Add(kGood, 4, kNever);
  }
  waiters.Join();
  EXPECT_EQ(waiters.order(), (std::vector<int>{2, 4, 3, 0, 1}));
}

TEST(FairGate, AClientThatAsksForLittleComesBeforeOneThatAsksForMuch) {
  FairGate gate(Slots(1));
  Waiters waiters(&gate);
  {
    const Turn turn(&gate, kAttacker, kNever);
    for (int i = 0; i < 5; ++i) {
      waiters.Add(kAttacker, i);
    }
    waiters.Add(kGood, 100);
    waiters.Add(kOther, 200);
  }
  waiters.Join();
  ASSERT_EQ(waiters.order().size(), 7u);
  EXPECT_GE(waiters.order()[0], 100);
  EXPECT_GE(waiters.order()[1], 100);
}

TEST(FairGate, OneTurnAClientComesBeforeASecondTurn) {
  FairGate gate(Slots(2));
  auto first = Enter(&gate, kAttacker);
  auto second = Enter(&gate, kOther);
  std::atomic<bool> good_entered{false};
  std::thread attacker([&] { const Turn turn(&gate, kAttacker, kNever); });
  while (gate.num_waiting() < 1) {
    std::this_thread::yield();
  }
  std::thread good([&] {
    const Turn turn(&gate, kGood, kNever);
    good_entered = true;
  });
  while (gate.num_waiting() < 2) {
    std::this_thread::yield();
  }
  second.reset();
  good.join();  // Although the attacker has waited longer.
  EXPECT_TRUE(good_entered);
  first.reset();
  attacker.join();
}

TEST(FairGate, LongTurnsDoNotKeepAnotherClientOut) {
  FairGate gate({.num_slots = 2, .max_waiting = 100, .patience = milliseconds(1)});
  const auto first = Enter(&gate, kAttacker);
  const auto second = Enter(&gate, kAttacker);
  EXPECT_EQ(Enter(&gate, kGood)->outcome(), Outcome::kEntered);  // While both turns are under way.
  EXPECT_EQ(Enter(&gate, kAttacker, Clock::now() + milliseconds(5))->outcome(), Outcome::kLate);
}

TEST(FairGate, NoMoreThanTwiceTheSlotsAreUsed) {
  FairGate gate({.num_slots = 1, .max_waiting = 100, .patience = milliseconds(0)});
  const auto first = Enter(&gate, kAttacker);
  const auto second = Enter(&gate, kGood);
  EXPECT_EQ(Enter(&gate, kOther, Clock::now() + milliseconds(5))->outcome(), Outcome::kLate);
}

// A turn that ends may leave room beside a long one.
TEST(FairGate, PatienceCountsAgainWhenATurnEnds) {
  FairGate gate({.num_slots = 1, .max_waiting = 100, .patience = milliseconds(1)});
  const auto first = Enter(&gate, kAttacker);
  auto second = Enter(&gate, kGood);
  Waiters waiters(&gate);
  waiters.Add(kOther, 0);
  second.reset();
  waiters.Join();  // `first` is still under way.
  EXPECT_EQ(waiters.order(), std::vector<int>{0});
}

// An attacker's turn that asks again and again whether to make room.
class LongTurn {
 public:
  explicit LongTurn(FairGate* gate, Clock::time_point deadline = kNever)
      : thread_([this, gate, deadline] {
          Turn turn(gate, kAttacker, deadline);
          has_entered_ = true;
          while (!may_end_) {
            turn.MakeRoom();
            ++num_pieces_;
          }
        }) {
    while (!has_entered_) {
      std::this_thread::yield();
    }
  }
  ~LongTurn() {
    may_end_ = true;
    thread_.join();
  }
  int num_pieces() const { return num_pieces_; }

 private:
  std::atomic<bool> has_entered_{false}, may_end_{false};
  std::atomic<int> num_pieces_{0};
  std::thread thread_;
};

void WaitUntilPaused(const FairGate& gate, int num_paused) {
  while (gate.num_paused() != num_paused) {
    std::this_thread::yield();
  }
}

const FairGateOptions kTwoSlots = {.num_slots = 2, .max_waiting = 100, .patience = milliseconds(0)};

TEST(FairGate, ALongTurnPausesWhileAnotherClientComputes) {
  FairGate gate(kTwoSlots);
  const auto other = Enter(&gate, kAttacker);
  const LongTurn attacker(&gate);
  for (int i = 0; i < 3; ++i) {
    const auto good = Enter(&gate, kGood);
    WaitUntilPaused(gate, 1);
    const int num_pieces = attacker.num_pieces();
    EXPECT_EQ(Enter(&gate, kAttacker, Clock::now() + milliseconds(5))->outcome(), Outcome::kLate);
    EXPECT_EQ(attacker.num_pieces(), num_pieces);
  }
  WaitUntilPaused(gate, 0);  // The slot is free again.
}

TEST(FairGate, ATurnPausesForHalfOfItsTimeOnly) {
  FairGate gate(kTwoSlots);
  const auto other = Enter(&gate, kAttacker);
  const Clock::time_point start = Clock::now();
  Turn attacker(&gate, kAttacker, start + milliseconds(40));
  const auto good = Enter(&gate, kGood);
  attacker.MakeRoom();  // Returns, although the other turns do not end.
  EXPECT_GE(Clock::now(), start + milliseconds(20));
  attacker.MakeRoom();
  EXPECT_EQ(gate.num_paused(), 0);
}

// What a client asks for one after the other takes as long as before. Any of these would pause for
// half an hour.
TEST(FairGate, AClientsOnlyTurnDoesNotPause) {
  FairGate gate(kTwoSlots);
  const auto first = Enter(&gate, kAttacker);
  const auto second = Enter(&gate, kGood);
  const auto third = Enter(&gate, kOther);
  first->MakeRoom();
  second->MakeRoom();
  third->MakeRoom();
  EXPECT_EQ(gate.num_paused(), 0);
}

TEST(FairGate, NoTurnPausesWhileThereAreSlotsForAll) {
  FairGateOptions options = kTwoSlots;
  options.num_slots = 3;
  FairGate gate(options);
  const auto first = Enter(&gate, kAttacker);
  const auto second = Enter(&gate, kAttacker);
  const auto good = Enter(&gate, kGood);
  first->MakeRoom();
  EXPECT_EQ(gate.num_paused(), 0);
}

// Who asks for an answer within two seconds does not wait for what may take a minute.
TEST(FairGate, ALongTurnPausesForAnEarlierDeadlineOfItsClient) {
  FairGate gate({.num_slots = 1, .max_waiting = 100, .patience = milliseconds(0)});
  const LongTurn slow(&gate, kNever + hours(1));
  for (int i = 0; i < 3; ++i) {
    const auto urgent = Enter(&gate, kAttacker, kNever);
    EXPECT_EQ(urgent->outcome(), Outcome::kEntered);
    EXPECT_EQ(gate.num_paused(), 1);
    const int num_pieces = slow.num_pieces();
    EXPECT_EQ(Enter(&gate, kAttacker, Clock::now() + milliseconds(5))->outcome(), Outcome::kLate);
    EXPECT_EQ(slow.num_pieces(), num_pieces);  // Two turns are under way, and one computes.
  }
  WaitUntilPaused(gate, 0);
}

TEST(FairGate, ALongTurnDoesNotPauseForALaterDeadlineOfItsClient) {
  FairGate gate({.num_slots = 1, .max_waiting = 100, .patience = milliseconds(0)});
  Waiters waiters(&gate);
  {
    Turn first(&gate, kAttacker, kNever);
    waiters.Add(kAttacker, 0, kNever + hours(1));
    first.MakeRoom();  // Would pause for half an hour.
    EXPECT_EQ(gate.num_waiting(), 1);
  }
  waiters.Join();
}

// What has begun holds memory.
TEST(FairGate, APausedTurnGoesOnBeforeItsClientBeginsAnother) {
  FairGate gate(kTwoSlots);
  Waiters waiters(&gate);
  const auto other = Enter(&gate, kAttacker);
  const LongTurn attacker(&gate);
  auto good = Enter(&gate, kGood);
  WaitUntilPaused(gate, 1);
  waiters.Add(kAttacker, 0, kNever + hours(1));
  good.reset();
  WaitUntilPaused(gate, 0);
  EXPECT_EQ(gate.num_waiting(), 1);
}

TEST(FairGate, TheClientWithMostWaitingRequestsLosesOne) {
  FairGateOptions options = Slots(1);
  options.max_waiting = 3;
  FairGate gate(options);
  Waiters waiters(&gate);
  {
    const Turn turn(&gate, kAttacker, kNever);
    for (int i = 0; i < 3; ++i) {
      waiters.Add(kAttacker, i);
    }
    waiters.Add(kGood, 100);
    EXPECT_EQ(gate.num_waiting(), 3);
  }
  waiters.Join();
  EXPECT_EQ(waiters.refused(), 2);
  EXPECT_EQ(waiters.order(), (std::vector<int>{100, 0, 1}));
}

TEST(FairGate, WhoGivesUpLosesItsPlaceOnly) {
  FairGate gate(Slots(1));
  auto turn = Enter(&gate, kGood);
  EXPECT_EQ(Enter(&gate, kGood, Clock::now())->outcome(), Outcome::kLate);
  EXPECT_EQ(gate.num_waiting(), 0);
  Waiters waiters(&gate);
  waiters.Add(kGood, 0);
  EXPECT_EQ(Enter(&gate, kGood, Clock::now())->outcome(), Outcome::kLate);
  turn.reset();
  waiters.Join();
  EXPECT_EQ(waiters.order(), std::vector<int>{0});
  EXPECT_EQ(Enter(&gate, kGood, Clock::now())->outcome(), Outcome::kEntered);  // The slot is free.
}

TEST(FairGate, ManyClientsAreForgotten) {
  FairGate gate(Slots(1));
  for (FairGate::ClientId client = 0; client < 5000; ++client) {
    EXPECT_EQ(Enter(&gate, client)->outcome(), Outcome::kEntered);
  }
}

}  // namespace
}  // namespace cairn
