#include "http/net/lead.h"

#include <utility>

namespace cairn {

void Lead::Take() {
  thread_local const auto self = std::make_shared<Follower>();
  {
    const std::lock_guard lock(mutex_);
    if (!is_taken_) {
      is_taken_ = true;
      return;
    }
    followers_.push_back(self);
  }
  self->promoted.acquire();
}

void Lead::Pass() {
  std::shared_ptr<Follower> next;
  {
    const std::lock_guard lock(mutex_);
    is_taken_ = !followers_.empty();
    if (!is_taken_) {
      return;
    }
    next = std::move(followers_.back());
    followers_.pop_back();
  }
  next->promoted.release();
}

}  // namespace cairn
