#include "http/service/fair_gate.h"

namespace cairn {

bool FairGate::Enter(std::chrono::steady_clock::time_point deadline) {
  std::unique_lock<std::mutex> lock(mutex_);
  if (num_free_ > 0) {
    --num_free_;
    return true;
  }
  Waiter waiter;
  const auto place = waiters_.insert(waiters_.end(), &waiter);
  if (!waiter.admitted.wait_until(lock, deadline, [&] { return waiter.is_admitted; })) {
    waiters_.erase(place);
    return false;
  }
  return true;
}

void FairGate::Leave() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (waiters_.empty()) {
    ++num_free_;
    return;
  }
  // Hands the slot to the waiter under the lock, because the waiter is destroyed once it wakes.
  waiters_.front()->is_admitted = true;
  waiters_.front()->admitted.notify_one();
  waiters_.pop_front();
}

int FairGate::num_waiting() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return static_cast<int>(waiters_.size());
}

}  // namespace cairn
