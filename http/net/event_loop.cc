#include "http/net/event_loop.h"

#include <fmt/format.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

#include "core/error.h"
#include "core/logging.h"

namespace cairn {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr int kMaxEvents = 128;
// Threads return answered connections without waking the loop, so the loop may see their deadlines
// this late.
constexpr milliseconds kMaxSleepWhileLent{500};
// Minimum interval between two checks of the deadlines.
constexpr milliseconds kExpiryGrain{10};
// At Stop, time allowed for the first byte of a new connection, which may be on its way.
constexpr milliseconds kFirstByteTime{100};
constexpr milliseconds kReportInterval{1000};

[[noreturn]] void ThrowSystemError(const char* what) {
  throw Error(ErrorCode::kIo, fmt::format("cannot create {}: {}", what, std::strerror(errno)));
}

}  // namespace

EventLoop::EventLoop(Socket listening, const ConnectionLimits& connection_limits,
                     const LoopLimits& loop_limits, int max_answering, RefuseFunction refuse)
    : listening_(std::move(listening)),
      connection_limits_(connection_limits),
      limits_(loop_limits),
      max_answering_(max_answering),
      refuse_(std::move(refuse)),
      epoll_(epoll_create1(EPOLL_CLOEXEC)),
      wake_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      next_expiry_(TimePoint::max()) {
  if (epoll_.fd() < 0 || wake_.fd() < 0) {
    ThrowSystemError("an event loop");
  }
  epoll_event wake{.events = EPOLLIN, .data = {.ptr = &wake_}};
  epoll_event accept{.events = EPOLLIN, .data = {.ptr = &listening_}};
  if (epoll_ctl(epoll_.fd(), EPOLL_CTL_ADD, wake_.fd(), &wake) != 0 ||
      epoll_ctl(epoll_.fd(), EPOLL_CTL_ADD, listening_.fd(), &accept) != 0) {
    ThrowSystemError("an event loop");
  }
}

EventLoop::~EventLoop() = default;

std::optional<RequestJob> EventLoop::Next() {
  lead_.Take();
  std::optional<RequestJob> job = TakeReady();
  while (!job && !HasEnded()) {
    RunRound();
    job = TakeReady();
  }
  lead_.Pass();
  return job;
}

std::optional<RequestJob> EventLoop::TakeReady() {
  if (ready_.empty() || num_answering_ == max_answering_) {
    return std::nullopt;
  }
  ++num_answering_;
  std::optional<RequestJob> job = std::move(ready_.front());
  ready_.pop_front();
  return job;
}

void EventLoop::RunRound() {
  std::array<epoll_event, kMaxEvents> events;
  const int num_events = epoll_wait(epoll_.fd(), events.data(), kMaxEvents, WaitMs());
  TakeBackAnswered();
  AdvancePostponed();
  for (int i = 0; i < num_events; ++i) {
    void* const source = events[i].data.ptr;
    if (source == &wake_) {
      uint64_t count;
      [[maybe_unused]] const ssize_t ignored = read(wake_.fd(), &count, sizeof(count));
    } else if (source == &listening_) {
      AcceptSome();
    } else {
      HandleEvent(events[i].events, static_cast<Entry*>(source));
    }
  }
  TakeBackAnswered();  // Connections with an event meanwhile may come back without a Wake.
  if (stop_requested_ && !is_closing_) {
    BeginClosing();
  }
  const TimePoint now = steady_clock::now();
  if (accept_again_ && now >= *accept_again_) {
    ResumeAccepting();
  }
  if (now >= next_expiry_) {
    Expire();
  }
  std::erase_if(postponed_, [](const Entry* entry) { return entry->is_closed; });
  connections_.FreeClosed();
}

int EventLoop::WaitMs() {
  {
    const std::lock_guard lock(mutex_);
    wake_when_answered_ = !ready_.empty() || is_closing_;
    if (wake_when_answered_ && !answered_.empty()) {
      return 0;
    }
  }
  if (!postponed_.empty()) {
    return 0;
  }
  TimePoint wake_at = next_expiry_;
  if (accept_again_) {
    wake_at = std::min(wake_at, *accept_again_);
  }
  if (num_answering_ > 0) {
    wake_at = std::min(wake_at, steady_clock::now() + kMaxSleepWhileLent);
  }
  if (wake_at == TimePoint::max()) {
    return -1;
  }
  const auto left = std::chrono::ceil<milliseconds>(wake_at - steady_clock::now());
  return static_cast<int>(std::max<int64_t>(left.count(), 0));
}

void EventLoop::HandleEvent(uint32_t events, Entry* entry) {
  if (entry->is_closed) {
    return;
  }
  if (entry->is_lent) {
    entry->events_while_lent |= events;
    const std::lock_guard lock(mutex_);
    entry->has_event_while_lent = true;
    return;
  }
  if ((events & (EPOLLRDHUP | EPOLLHUP | EPOLLERR)) != 0) {
    entry->NotePeerFinished();
  } else if ((events & EPOLLIN) != 0) {
    entry->NoteReadable();
  }
  Advance(entry);
}

void EventLoop::Wake() {
  const uint64_t one = 1;
  [[maybe_unused]] const ssize_t ignored = write(wake_.fd(), &one, sizeof(one));
}

void EventLoop::Stop() {
  stop_requested_ = true;
  Wake();
}

void EventLoop::Advance(Entry* entry) {
  try {
    switch (entry->Proceed()) {
      case Connection::Next::kRequest:
        return Lend(entry);
      case Connection::Next::kClose:
        return connections_.Close(entry);
      case Connection::Next::kMore:
        Postpone(entry);
        break;
      case Connection::Next::kWait:
        break;
    }
    if (is_closing_ && entry->is_idle() && entry->has_served()) {
      return connections_.Close(entry);
    }
  } catch (const HttpError& error) {
    return Refuse(entry, error);
  } catch (const std::exception& error) {
    LogError("connection closed because of an error: {}", error.what());
    return connections_.Close(entry);
  }
  next_expiry_ = std::min(next_expiry_, DeadlineOf(*entry));
  Account(entry, entry->buffered_bytes());
}

void EventLoop::Postpone(Entry* entry) {
  if (!std::exchange(entry->is_postponed, true)) {
    postponed_.push_back(entry);
  }
}

void EventLoop::AdvancePostponed() {
  for (Entry* entry : std::exchange(postponed_, {})) {
    entry->is_postponed = false;
    if (!entry->is_closed && !entry->is_lent) {
      Advance(entry);
    }
  }
}

void EventLoop::Lend(Entry* entry) {
  ReceivedRequest request = entry->TakeRequest();
  Account(entry, entry->buffered_bytes() + request.body.capacity());
  if (entry->is_closed) {
    return;
  }
  entry->is_lent = true;
  ready_.push_back({entry, std::move(request)});
}

void EventLoop::Refuse(Entry* entry, const HttpError& error) {
  entry->Respond(refuse_(*entry, error), /*keep_alive=*/false);
  next_expiry_ = std::min(next_expiry_, DeadlineOf(*entry));
  // Proceed only sends and drains here, so it cannot refuse again.
  const Connection::Next next = entry->Proceed();
  if (next == Connection::Next::kClose) {
    return connections_.Close(entry);
  }
  if (next == Connection::Next::kMore) {
    Postpone(entry);
  }
  Account(entry, entry->buffered_bytes());
}

void EventLoop::TakeBack(Connection* connection) {
  auto* const entry = static_cast<Entry*>(connection);
  bool must_wake = entry->has_more();
  {
    const std::lock_guard lock(mutex_);
    must_wake = must_wake || wake_when_answered_ || entry->has_event_while_lent;
    answered_.push_back(entry);
  }
  if (must_wake) {
    Wake();
  }
}

void EventLoop::TakeBackAnswered() {
  std::vector<Entry*> answered;
  {
    const std::lock_guard lock(mutex_);
    answered.swap(answered_);
    for (Entry* entry : answered) {
      entry->has_event_while_lent = false;
    }
  }
  for (Entry* entry : answered) {
    entry->is_lent = false;
    --num_answering_;
    const uint32_t events = std::exchange(entry->events_while_lent, 0);
    next_expiry_ = std::min(next_expiry_, DeadlineOf(*entry));
    HandleEvent(events, entry);
  }
}

EventLoop::TimePoint EventLoop::DeadlineOf(const Entry& entry) const {
  if (is_closing_ && entry.is_idle()) {
    return entry.waiting_since() + kFirstByteTime;
  }
  return std::min(entry.deadline(), closing_deadline_);
}

void EventLoop::Expire() {
  const TimePoint now = steady_clock::now();
  std::vector<Entry*> late;
  next_expiry_ = TimePoint::max();
  for (const auto& entry : connections_.entries()) {
    if (entry->is_lent) {
      continue;
    }
    const TimePoint deadline = DeadlineOf(*entry);
    if (deadline <= now) {
      late.push_back(entry.get());
    } else {
      next_expiry_ = std::min(next_expiry_, deadline);
    }
  }
  for (Entry* entry : late) {
    if (!entry->is_closed && entry->waits_for_batch()) {
      entry->NoteReadable();  // Bytes may have come that were too few for an event.
      Advance(entry);
    }
    if (entry->is_closed || entry->is_lent || DeadlineOf(*entry) > now) {
      continue;
    }
    try {
      entry->GiveUp();
      if (entry->is_sending()) {
        entry->socket().Abort();
      }
      connections_.Close(entry);
    } catch (const HttpError& error) {
      Refuse(entry, error);
    }
  }
  if (next_expiry_ != TimePoint::max()) {
    next_expiry_ = std::max(next_expiry_, now + kExpiryGrain);
  }
}

void EventLoop::BeginClosing() {
  AcceptSome();  // Accepts the connections made before Stop.
  listening_.Close();
  accept_again_.reset();
  is_closing_ = true;
  next_expiry_ = steady_clock::now();
  closing_deadline_ = next_expiry_ + limits_.stop_timeout;
  std::vector<Entry*> served;
  for (const auto& entry : connections_.entries()) {
    if (!entry->is_lent && entry->is_idle() && entry->has_served()) {
      served.push_back(entry.get());
    }
  }
  for (Entry* entry : served) {
    connections_.Close(entry);
  }
}

void EventLoop::Account(Entry* entry, size_t bytes) {
  connections_.Count(bytes, entry);
  while (connections_.buffered_bytes() > limits_.max_buffered_bytes &&
         Drop(connections_.HeaviestWaiting(limits_.max_buffered_bytes))) {
    ReportShortage("too many bytes of requests and answers in memory");
  }
}

bool EventLoop::Drop(Entry* entry) {
  if (entry == nullptr) {
    return false;
  }
  LogDebug("closing a connection of {} to make room", entry->peer().address);
  entry->socket().Abort();
  connections_.Close(entry);
  ++num_dropped_;
  return true;
}

void EventLoop::ReportShortage(const char* cause) {
  const TimePoint now = steady_clock::now();
  if (now < next_report_) {
    return;
  }
  next_report_ = now + kReportInterval;
  LogWarning("{} connections were closed or refused: {}", std::exchange(num_dropped_, 0), cause);
}

}  // namespace cairn
