// How the event loop accepts connections.
#include <sys/epoll.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <memory>
#include <utility>

#include "http/net/event_loop.h"

namespace cairn {
namespace {

constexpr int kMaxAcceptsARound = 64;
// Room above max_connections for connections that get status 503.
constexpr size_t kMaxTurnedAway = 64;
// How long accepting pauses when the system has no descriptors left and the loop cannot free any.
constexpr std::chrono::milliseconds kAcceptPause{100};

}  // namespace

void EventLoop::AcceptSome() {
  for (int i = 0; i < kMaxAcceptsARound && listening_.fd() >= 0; ++i) {
    Peer peer;
    Socket socket = Accept(listening_, connection_limits_.send_timeout, &peer);
    if (socket.fd() < 0) {
      HandleAcceptError(errno);
      return;
    }
    Adopt(std::move(socket), std::move(peer));
  }
}

void EventLoop::HandleAcceptError(int error) {
  const bool is_exhausted =
      error == EMFILE || error == ENFILE || error == ENOBUFS || error == ENOMEM;
  // With other errors, no connection waits or a waiting one has gone. The port stays readable for
  // the next.
  if (!is_exhausted) {
    return;
  }
  if (!Drop(connections_.LongestWaiting())) {
    PauseAccepting();
  }
  ReportShortage(std::strerror(error));
}

void EventLoop::PauseAccepting() {
  epoll_ctl(epoll_.fd(), EPOLL_CTL_DEL, listening_.fd(), nullptr);
  accept_again_ = std::chrono::steady_clock::now() + kAcceptPause;
}

void EventLoop::ResumeAccepting() {
  accept_again_.reset();
  epoll_event accept{.events = EPOLLIN, .data = {.ptr = &listening_}};
  if (epoll_ctl(epoll_.fd(), EPOLL_CTL_ADD, listening_.fd(), &accept) != 0) {
    PauseAccepting();
  }
}

void EventLoop::Adopt(Socket socket, Peer peer) {
  const auto max_connections = static_cast<size_t>(limits_.max_connections);
  bool is_full = connections_.entries().size() >= max_connections;
  if (is_full) {
    is_full = !Drop(connections_.LongestWaiting());
    num_dropped_ += is_full;
    ReportShortage("too many connections");
  }
  if (is_full && connections_.entries().size() >= max_connections + kMaxTurnedAway) {
    return;
  }
  auto entry = std::make_unique<Entry>(std::move(socket), std::move(peer), &connection_limits_);
  epoll_event event{.events = EPOLLIN | EPOLLOUT | EPOLLRDHUP | EPOLLET,
                    .data = {.ptr = entry.get()}};
  if (epoll_ctl(epoll_.fd(), EPOLL_CTL_ADD, entry->socket().fd(), &event) != 0) {
    return;
  }
  Entry* const adopted = connections_.Add(std::move(entry));
  next_expiry_ = std::min(next_expiry_, DeadlineOf(*adopted));
  if (is_full) {
    Refuse(adopted, HttpError(ProblemCode::kUnavailable, "too many requests are being answered"));
  } else {
    Advance(adopted);
  }
}

}  // namespace cairn
