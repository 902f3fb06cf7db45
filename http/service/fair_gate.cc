#include "http/service/fair_gate.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace cairn {
namespace {

// After this time, what a client has used counts half.
constexpr double kUseHalfLifeS = 10.0;
// Idle clients whose use is remembered.
constexpr size_t kMaxIdleClients = 1024;

double Seconds(FairGate::Clock::duration time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

double FairGate::Client::UsedSeconds(Clock::time_point now) const {
  return used_s * std::exp2(-Seconds(now - used_at) / kUseHalfLifeS);
}

FairGate::Turn::Turn(FairGate* gate, ClientId client, Clock::time_point deadline)
    : gate_(gate), deadline_(deadline) {
  std::unique_lock lock(gate->mutex_);
  client_ = &gate->clients_[client];
  gate->Queue(this);
  gate->Admit(Clock::now());
  if (gate->num_waiting_ > gate->options_.max_waiting) {
    gate->RefuseOne();
  }
  gate->Wait(&lock, this);
}

FairGate::Turn::~Turn() {
  const std::lock_guard lock(gate_->mutex_);
  if (outcome_ == Outcome::kEntered) {
    gate_->Leave(this);
  }
  gate_->ForgetIdleClients();
}

void FairGate::Queue(Turn* turn) {
  waiting_clients_.reserve(waiting_clients_.size() + 1);  // What may throw comes first.
  std::list<Turn*>& waiting = turn->client_->waiting;
  const auto earlier = std::find_if(waiting.rbegin(), waiting.rend(), [turn](const Turn* other) {
    return other->deadline_ <= turn->deadline_;
  });
  waiting.insert(earlier.base(), turn);
  if (waiting.size() == 1) {
    waiting_clients_.push_back(turn->client_);
  }
  ++num_waiting_;
}

void FairGate::Wait(std::unique_lock<std::mutex>* lock, Turn* turn) {
  while (turn->is_waiting_) {
    turn->changed_.wait_until(*lock, std::min(turn->deadline_, EndOfPatience(*turn->client_)));
    const Clock::time_point now = Clock::now();
    Admit(now);
    if (turn->is_waiting_ && now >= turn->deadline_) {
      StopWaiting(Outcome::kLate, turn);
    }
  }
}

void FairGate::Leave(Turn* turn) {
  const Clock::time_point now = Clock::now();
  Client* const client = turn->client_;
  client->used_s = client->UsedSeconds(now) + Seconds(turn->Computed(now));
  client->used_at = now;
  --client->num_running;
  running_.remove(turn);
  Admit(now);
  for (Client* waiting : waiting_clients_) {
    if (EndOfPatience(*waiting) != Clock::time_point::max()) {
      waiting->waiting.front()->changed_.notify_one();  // Its patience may end earlier now.
    }
  }
}

// A client without a turn comes before turns that pause, and those before further turns of clients
// that have one, because what has begun holds memory. Of one client, the earlier deadline comes
// first.
void FairGate::Admit(Clock::time_point now) {
  while (true) {
    Client* const client = waiting_clients_.empty() ? nullptr : NextClient(now);
    const bool may_enter = client != nullptr && MayEnter(*client, now);
    const bool may_resume = num_computing() < static_cast<size_t>(options_.num_slots);
    Turn* const paused = may_resume ? NextPaused(now) : nullptr;
    if (may_enter &&
        (client->num_running == 0 || paused == nullptr || IsUrgent(*client, *paused))) {
      Enter(client->waiting.front(), now);
    } else if (paused != nullptr) {
      Resume(paused, now);
    } else {
      return;
    }
  }
}

// True if the client waits for a turn with an earlier deadline than this turn of its own.
bool FairGate::IsUrgent(const Client& client, const Turn& turn) {
  return turn.client_ == &client && !client.waiting.empty() &&
         client.waiting.front()->deadline_ < turn.deadline_;
}

void FairGate::Enter(Turn* turn, Clock::time_point now) {
  running_.push_back(turn);
  turn->start_ = now;
  ++turn->client_->num_running;
  StopWaiting(Outcome::kEntered, turn);
}

void FairGate::Turn::MakeRoom() {
  std::unique_lock lock(gate_->mutex_);
  const Clock::time_point now = Clock::now();
  if (gate_->MustPause(*this, now)) {
    gate_->Pause(&lock, this, now);
  }
}

bool FairGate::MustPause(const Turn& turn, Clock::time_point now) const {
  const auto num_slots = static_cast<size_t>(options_.num_slots);
  if (num_computing() < num_slots || turn.Computed(now) < options_.patience ||
      turn.PauseLeft() <= Clock::duration::zero()) {
    return false;
  }
  if (num_computing() == num_slots) {
    // Otherwise Admit would let this turn go on.
    return running_.size() < 2 * num_slots && IsUrgent(*turn.client_, turn) &&
           NextClient(now) == turn.client_;
  }
  return std::any_of(running_.begin(), running_.end(), [&](const Turn* other) {
    return !other->is_paused_ && other->client_->num_computing() < turn.client_->num_computing();
  });
}

void FairGate::Pause(std::unique_lock<std::mutex>* lock, Turn* turn, Clock::time_point now) {
  const Clock::time_point end = now + turn->PauseLeft();
  turn->is_paused_ = true;
  turn->pause_start_ = now;
  ++turn->client_->num_paused;
  ++num_paused_;
  Admit(now);
  while (turn->is_paused_) {
    if (turn->changed_.wait_until(*lock, end) == std::cv_status::timeout && turn->is_paused_) {
      Resume(turn, Clock::now());
    }
  }
}

void FairGate::Resume(Turn* turn, Clock::time_point now) {
  turn->is_paused_ = false;
  turn->paused_ += now - turn->pause_start_;
  --turn->client_->num_paused;
  --num_paused_;
  turn->changed_.notify_one();
}

FairGate::Turn* FairGate::NextPaused(Clock::time_point now) const {
  Turn* next = nullptr;
  const auto rank = [now](const Turn* turn) {
    const Client& client = *turn->client_;
    return std::tuple(client.num_computing(), client.UsedSeconds(now), turn->deadline_);
  };
  for (Turn* turn : running_) {
    if (turn->is_paused_ && (next == nullptr || rank(turn) < rank(next))) {
      next = turn;
    }
  }
  return next;
}

FairGate::Client* FairGate::NextClient(Clock::time_point now) const {
  const auto rank = [now](const Client* client) {
    return std::tuple(client->num_running, client->UsedSeconds(now));
  };
  return *std::min_element(waiting_clients_.begin(), waiting_clients_.end(),
                           [&](const Client* a, const Client* b) { return rank(a) < rank(b); });
}

bool FairGate::MayEnter(const Client& client, Clock::time_point now) const {
  const auto num_slots = static_cast<size_t>(options_.num_slots);
  return (num_computing() < num_slots && running_.size() < 2 * num_slots) ||
         EndOfPatience(client) <= now;
}

FairGate::Clock::time_point FairGate::EndOfPatience(const Client& client) const {
  const auto num_slots = static_cast<size_t>(options_.num_slots);
  if (client.num_running > 0 || num_computing() < num_slots || running_.size() >= 2 * num_slots) {
    return Clock::time_point::max();
  }
  // Fewer than num_slots turns are short so far once this one is long.
  size_t num_later = 0;
  const auto turn = std::find_if(running_.rbegin(), running_.rend(), [&](const Turn* other) {
    num_later += other->is_paused_ ? 0 : 1;
    return num_later == num_slots;
  });
  return (*turn)->start_ + options_.patience;
}

void FairGate::RefuseOne() {
  const Client* const most = *std::max_element(
      waiting_clients_.begin(), waiting_clients_.end(),
      [](const Client* a, const Client* b) { return a->waiting.size() < b->waiting.size(); });
  StopWaiting(Outcome::kRefused, most->waiting.back());
}

void FairGate::StopWaiting(Outcome outcome, Turn* turn) {
  Client* const client = turn->client_;
  client->waiting.remove(turn);
  if (client->waiting.empty()) {
    std::erase(waiting_clients_, client);
  }
  --num_waiting_;
  turn->outcome_ = outcome;
  turn->is_waiting_ = false;
  turn->changed_.notify_one();
  if (outcome != Outcome::kEntered && !client->waiting.empty()) {
    client->waiting.front()->changed_.notify_one();  // It now waits for the end of patience.
  }
}

void FairGate::ForgetIdleClients() {
  if (clients_.size() > kMaxIdleClients) {
    std::erase_if(clients_, [](const auto& entry) { return entry.second.is_idle(); });
  }
}

int FairGate::num_waiting() const {
  const std::lock_guard lock(mutex_);
  return num_waiting_;
}

int FairGate::num_paused() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(num_paused_);
}

}  // namespace cairn
