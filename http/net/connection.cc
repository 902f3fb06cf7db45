#include "http/net/connection.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "http/problem.h"

namespace cairn {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

// How often an idle connection asks whether it should give its worker up.
constexpr milliseconds kIdleSlice{25};
// How long a new connection may keep its worker from others before its first byte; it just opened,
// so that byte is on its way.
constexpr milliseconds kFirstPatience{100};
constexpr size_t kReceiveBytes = 64 * 1024;
// What FinishSending swallows at most.
constexpr size_t kMaxDrainBytes = size_t{8} << 20;
constexpr milliseconds kDrainTime{1000};

milliseconds Until(steady_clock::time_point deadline) {
  const auto left = std::chrono::ceil<milliseconds>(deadline - steady_clock::now());
  return std::max(left, milliseconds(0));
}

// True if the socket can be read (or has ended) within `wait`.
bool PollReadable(int socket, milliseconds wait) {
  pollfd poll_fd{.fd = socket, .events = POLLIN, .revents = 0};
  return poll(&poll_fd, 1, static_cast<int>(wait.count())) > 0;
}

}  // namespace

Connection::Connection(int socket, const ConnectionLimits& limits,
                       std::function<bool()> give_up_idle)
    : socket_(socket), limits_(limits), give_up_idle_(std::move(give_up_idle)) {}

Connection::ReadResult Connection::ReadSome(TimePoint deadline) {
  if (!PollReadable(socket_, Until(deadline))) return ReadResult::kTimeout;
  std::array<char, kReceiveBytes> chunk;
  ssize_t received;
  do {
    received = recv(socket_, chunk.data(), chunk.size(), MSG_DONTWAIT);
  } while (received < 0 && errno == EINTR);
  if (received <= 0) return ReadResult::kClosed;
  buffer_.append(chunk.data(), static_cast<size_t>(received));
  return ReadResult::kData;
}

bool Connection::WaitForFirstByte() {
  const TimePoint start = steady_clock::now();
  const TimePoint deadline = start + limits_.idle_timeout;
  const TimePoint patient_until = start + (is_new_ ? kFirstPatience : milliseconds(0));
  is_new_ = false;
  while (true) {
    // A client may send an empty line after a body (RFC 9112 section 2.2).
    buffer_.erase(0, buffer_.find_first_not_of("\r\n"));
    if (!buffer_.empty()) return true;
    const TimePoint now = steady_clock::now();
    if (now >= deadline || (now >= patient_until && give_up_idle_())) return false;
    if (ReadSome(std::min(deadline, now + kIdleSlice)) == ReadResult::kClosed) return false;
  }
}

std::optional<size_t> Connection::ReadHead() {
  const TimePoint deadline = steady_clock::now() + limits_.head_timeout;
  size_t searched = 0;
  while (true) {
    const size_t end = buffer_.find("\r\n\r\n", searched);
    const size_t head_bytes = end == std::string::npos ? buffer_.size() : end + 4;
    if (head_bytes > limits_.head.max_head_bytes) {
      const bool in_first_line = buffer_.find("\r\n") > limits_.head.max_target_bytes;
      throw HttpError(
          in_first_line ? ProblemCode::kUriTooLong : ProblemCode::kHeadersTooLarge,
          fmt::format("the request head is longer than {} bytes", limits_.head.max_head_bytes));
    }
    if (end != std::string::npos) return head_bytes;
    searched = buffer_.size() < 3 ? 0 : buffer_.size() - 3;
    switch (ReadSome(deadline)) {
      case ReadResult::kData:
        break;
      case ReadResult::kClosed:
        return std::nullopt;
      case ReadResult::kTimeout:
        throw HttpError(ProblemCode::kRequestTimeout, "the head did not arrive in time");
    }
  }
}

bool Connection::ReadBody(size_t num_bytes) {
  const TimePoint deadline = steady_clock::now() + limits_.body_timeout;
  buffer_.reserve(num_bytes);
  while (buffer_.size() < num_bytes) {
    switch (ReadSome(deadline)) {
      case ReadResult::kData:
        break;
      case ReadResult::kClosed:
        return false;
      case ReadResult::kTimeout:
        throw HttpError(
            ProblemCode::kRequestTimeout,
            fmt::format("{} of {} body bytes arrived in time", buffer_.size(), num_bytes));
    }
  }
  return true;
}

std::optional<ReceivedRequest> Connection::ReadRequest() {
  if (!WaitForFirstByte()) return std::nullopt;
  const TimePoint arrival = steady_clock::now();
  const std::optional<size_t> head_bytes = ReadHead();
  if (!head_bytes) return std::nullopt;
  ReceivedRequest request;
  request.arrival = arrival;
  request.head = ParseRequestHead(std::string_view(buffer_).substr(0, *head_bytes), limits_.head);
  buffer_.erase(0, *head_bytes);
  const size_t body_bytes = request.head.content_length;
  if (request.head.expects_continue && buffer_.size() < body_bytes &&
      !Send("HTTP/1.1 100 Continue\r\n\r\n")) {
    return std::nullopt;
  }
  if (!ReadBody(body_bytes)) return std::nullopt;
  if (buffer_.size() == body_bytes) {
    request.body.swap(buffer_);
  } else {
    request.body = buffer_.substr(0, body_bytes);
    buffer_.erase(0, body_bytes);
  }
  return request;
}

bool Connection::Send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<size_t>(sent));
  }
  return true;
}

void Connection::FinishSending() {
  shutdown(socket_, SHUT_WR);
  const TimePoint deadline = steady_clock::now() + kDrainTime;
  size_t drained = 0;
  while (drained < kMaxDrainBytes) {
    buffer_.clear();
    if (ReadSome(deadline) != ReadResult::kData) return;
    drained += buffer_.size();
  }
}

}  // namespace cairn
