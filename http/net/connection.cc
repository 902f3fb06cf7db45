#include "http/net/connection.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include "core/wire/problem.h"

namespace cairn {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr size_t kReceiveBytes = 64 * 1024;
// Bytes of a body, or behind the last response, that are worth a look at the connection. A client
// that sends a body a byte at a time would otherwise wake the event loop for each byte. Small
// beside the kernel's buffers, and at the least rate of a body a few seconds' worth, so that the
// peer's deadline stays exact enough.
constexpr size_t kBodyBatch = 16 * 1024;
// Capacity that the buffer of an idle connection keeps.
constexpr size_t kIdleBytes = 4096;
// Bytes of empty lines before a request. Clients send one such line at most.
constexpr size_t kMaxEmptyBytes = 16;
// Bytes discarded at most after the last response, unless a body may be longer. Closing a socket
// with unread data resets the connection, and the peer could not read the response.
constexpr size_t kMaxDrainBytes = size_t{8} << 20;
// How long a peer may be silent meanwhile. One that goes on sending, as clients do that look for a
// response only after their upload, may do so for the time of a body.
constexpr milliseconds kDrainTime{1000};
// The stated idle time passes at the client's end a little later than here, and a request that the
// client sends in the last moment is still on its way.
constexpr milliseconds kIdleGrace{2000};

bool WouldBlock() { return errno == EAGAIN || errno == EWOULDBLOCK; }

void Release(std::string* text) { std::string().swap(*text); }

}  // namespace

Connection::Connection(Socket socket, Peer peer, const ConnectionLimits* limits)
    : socket_(std::move(socket)), peer_(std::move(peer)), limits_(limits) {
  Enter(Phase::kIdle, limits_->idle_timeout);
}

void Connection::Enter(Phase phase, milliseconds time) {
  phase_ = phase;
  waiting_since_ = steady_clock::now();
  deadline_ = waiting_since_ + time;
}

Connection::Next Connection::Proceed() {
  budget_bytes_ = limits_->max_bytes_a_pass;
  while (true) {
    if (phase_ == Phase::kDraining) {
      return Drain();
    }
    // Outside kSending, at most "100 Continue" is unsent.
    const Transfer sent = SendSome();
    if (sent == Transfer::kBroken) {
      return Next::kClose;
    }
    if (phase_ == Phase::kSending) {
      if (sent == Transfer::kBlocked) {
        return Next::kWait;
      }
      FinishResponse();
      continue;
    }
    if (FindRequest()) {
      return Next::kRequest;
    }
    if (budget_bytes_ <= 0) {
      return Next::kMore;
    }
    if (out_.head.empty() || sent == Transfer::kBlocked) {
      const Transfer received = ReadSome();
      if (received == Transfer::kBroken) {
        return Next::kClose;
      }
      if (received == Transfer::kBlocked) {
        return Next::kWait;
      }
    }
  }
}

// A client may send an empty line after a body (RFC 9112 section 2.2).
void Connection::SkipEmptyLines() {
  const size_t num_bytes = std::min(in_.find_first_not_of("\r\n"), in_.size());
  in_.erase(0, num_bytes);
  num_empty_bytes_ += num_bytes;
  if (num_empty_bytes_ > kMaxEmptyBytes) {
    throw HttpError(ProblemCode::kBadRequest, "there are empty lines where a request should begin");
  }
}

bool Connection::FindRequest() {
  if (phase_ == Phase::kIdle) {
    SkipEmptyLines();
    if (in_.empty()) {
      return false;
    }
    num_empty_bytes_ = 0;
    Enter(Phase::kHead, limits_->head_timeout);
    request_ = {};
    num_searched_ = 0;
  }
  if (phase_ == Phase::kHead && FindHead()) {
    Enter(Phase::kBody, limits_->body_timeout);
    if (limits_->check_head && in_.size() < request_.head.content_length) {
      limits_->check_head(request_.head);
    }
    if (request_.head.expects_continue && in_.size() < request_.head.content_length) {
      out_.head += "HTTP/1.1 100 Continue\r\n\r\n";
    }
    ExpectBody();
  }
  return phase_ == Phase::kBody && in_.size() >= request_.head.content_length;
}

void Connection::ExpectBody() {
  const size_t length = request_.head.content_length;
  ExpectBytes(in_.size() < length ? std::min(length - in_.size(), kBodyBatch) : 1);
}

// Sockets that cannot count report each byte, which costs only time.
void Connection::ExpectBytes(size_t num_bytes) {
  if (num_bytes != num_expected_bytes_) {
    num_expected_bytes_ = num_bytes;
    const int value = static_cast<int>(num_bytes);
    setsockopt(socket_.fd(), SOL_SOCKET, SO_RCVLOWAT, &value, sizeof(value));
  }
}

bool Connection::FindHead() {
  const size_t end = in_.find("\r\n\r\n", num_searched_);
  const size_t head_bytes = end == std::string::npos ? in_.size() : end + 4;
  if (head_bytes > kMaxHeadBytes) {
    const bool in_first_line = in_.find("\r\n") > kMaxTargetBytes;
    throw HttpError(in_first_line ? ProblemCode::kUriTooLong : ProblemCode::kHeadersTooLarge,
                    fmt::format("the request head is longer than {} bytes", kMaxHeadBytes));
  }
  num_searched_ = in_.size() < 3 ? 0 : in_.size() - 3;
  if (end == std::string::npos) {
    return false;
  }
  request_.head =
      ParseRequestHead(std::string_view(in_).substr(0, head_bytes), limits_->max_body_bytes);
  in_.erase(0, head_bytes);
  return true;
}

ReceivedRequest Connection::TakeRequest() {
  const size_t body_bytes = request_.head.content_length;
  if (in_.size() == body_bytes) {
    request_.body.swap(in_);
  } else {
    request_.body = in_.substr(0, body_bytes);
    in_.erase(0, body_bytes);
  }
  phase_ = Phase::kAnswering;
  request_.arrival = steady_clock::now();
  return std::move(request_);
}

void Connection::Respond(ResponseText text, bool keep_alive) {
  ExpectBytes(1);
  out_.head.erase(0, num_sent_);
  num_sent_ = 0;
  out_.head += text.head;
  out_.body = std::move(text.body);
  keep_alive_ = keep_alive;
  has_served_ = true;
  const auto num_bytes = static_cast<int64_t>(out_.head.size() + out_.body.size());
  Enter(Phase::kSending,
        limits_->send_timeout + milliseconds(1000 * num_bytes / limits_->min_send_bytes_per_s));
  if (SendSome() == Transfer::kDone) {
    FinishResponse();
  }
}

void Connection::GiveUp() const {
  if ((phase_ == Phase::kHead || phase_ == Phase::kBody) && steady_clock::now() < deadline_) {
    throw HttpError(ProblemCode::kUnavailable, "the server is stopping")
        .Hint("send the request again in a moment");
  }
  if (phase_ == Phase::kHead) {
    throw HttpError(ProblemCode::kRequestTimeout, "the head did not arrive in time");
  }
  if (phase_ == Phase::kBody) {
    throw HttpError(ProblemCode::kRequestTimeout,
                    fmt::format("{} of {} body bytes arrived in time", in_.size(),
                                request_.head.content_length))
        .Hint(fmt::format("send {} bytes a second or more", limits_->min_body_bytes_per_s));
  }
}

Connection::Transfer Connection::ReadSome() {
  if (!is_readable_) {
    return Transfer::kBlocked;
  }
  std::array<char, kReceiveBytes> chunk;
  ssize_t received;
  do {
    received = recv(socket_.fd(), chunk.data(), chunk.size(), MSG_DONTWAIT);
  } while (received < 0 && errno == EINTR);
  if (received < 0 && WouldBlock()) {
    is_readable_ = false;
    return Transfer::kBlocked;
  }
  if (received <= 0) {
    return Transfer::kBroken;
  }
  // A short read empties the socket; the next edge is still to come.
  is_readable_ = peer_has_finished_ || received == static_cast<ssize_t>(chunk.size());
  budget_bytes_ -= received;
  if (phase_ != Phase::kDraining) {
    in_.append(chunk.data(), static_cast<size_t>(received));
  }
  if (phase_ == Phase::kBody) {
    RewardBody(received);
    ExpectBody();
  } else if (phase_ == Phase::kDraining) {
    RewardDraining(received);
  }
  return Transfer::kDone;
}

void Connection::RewardBody(int64_t num_bytes) {
  // In nanoseconds, because a body may come in segments of one byte.
  const std::chrono::nanoseconds earned(1'000'000'000 * num_bytes / limits_->min_body_bytes_per_s);
  deadline_ = std::min(deadline_ + earned, steady_clock::now() + limits_->body_timeout);
}

void Connection::RewardDraining(int64_t num_bytes) {
  num_drained_ += static_cast<size_t>(num_bytes);
  const std::chrono::nanoseconds earned(1'000'000'000 * num_bytes / limits_->min_body_bytes_per_s);
  const steady_clock::time_point now = steady_clock::now();
  deadline_ =
      std::min({deadline_ + earned, now + kDrainTime, waiting_since_ + limits_->body_timeout});
}

Connection::Transfer Connection::SendSome() {
  const size_t num_bytes = out_.head.size() + out_.body.size();
  while (num_sent_ < num_bytes) {
    const size_t head_sent = std::min(num_sent_, out_.head.size());
    const size_t body_sent = num_sent_ - head_sent;
    std::array<iovec, 2> parts = {
        iovec{.iov_base = out_.head.data() + head_sent, .iov_len = out_.head.size() - head_sent},
        iovec{.iov_base = out_.body.data() + body_sent, .iov_len = out_.body.size() - body_sent}};
    msghdr message{};
    message.msg_iov = parts.data();
    message.msg_iovlen = parts.size();
    const ssize_t sent = sendmsg(socket_.fd(), &message, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && errno == EINTR) {
      continue;
    }
    if (sent < 0) {
      return WouldBlock() ? Transfer::kBlocked : Transfer::kBroken;
    }
    num_sent_ += static_cast<size_t>(sent);
  }
  Release(&out_.head);
  Release(&out_.body);
  num_sent_ = 0;
  return Transfer::kDone;
}

void Connection::FinishResponse() {
  if (keep_alive_) {
    if (in_.empty() && in_.capacity() > kIdleBytes) {
      Release(&in_);
    }
    Enter(Phase::kIdle, limits_->idle_timeout + kIdleGrace);
    return;
  }
  shutdown(socket_.fd(), SHUT_WR);
  Release(&in_);
  Enter(Phase::kDraining, kDrainTime);
  ExpectBytes(kBodyBatch);
}

Connection::Next Connection::Drain() {
  while (num_drained_ < std::max(kMaxDrainBytes, limits_->max_body_bytes)) {
    const Transfer received = ReadSome();
    if (received == Transfer::kBlocked) {
      return Next::kWait;
    }
    if (received == Transfer::kBroken) {
      break;
    }
    if (budget_bytes_ <= 0) {
      return Next::kMore;
    }
  }
  return Next::kClose;
}

size_t Connection::buffered_bytes() const {
  return in_.capacity() + request_.body.capacity() + out_.head.capacity() + out_.body.capacity();
}

}  // namespace cairn
