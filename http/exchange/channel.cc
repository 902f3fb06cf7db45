#include "http/exchange/channel.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string_view>

namespace cairn {

bool WaitForSocket(int socket, short events, ExchangeClock::time_point deadline) {
  while (true) {
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(deadline - ExchangeClock::now()).count();
    if (left <= 0) {
      return false;
    }
    pollfd waiting{.fd = socket, .events = events, .revents = 0};
    const int ready = poll(&waiting, 1, static_cast<int>(std::min<int64_t>(left, 60'000)));
    if (ready > 0 || (ready < 0 && errno != EINTR)) {
      return true;  // An error shows in the next call.
    }
  }
}

bool Channel::Wait(short events) {
  is_late_ = is_late_ || !WaitForSocket(socket_, events, deadline_);
  return !is_late_;
}

std::ptrdiff_t Channel::ReceiveRaw(char* to, size_t size) {
  while (Wait(POLLIN)) {
    const ssize_t received = recv(socket_, to, size, MSG_DONTWAIT);
    if (received >= 0 || (errno != EAGAIN && errno != EINTR)) {
      return received;
    }
  }
  return -1;
}

bool Channel::SendRaw(const char* from, size_t size) {
  while (size > 0 && Wait(POLLOUT)) {
    const ssize_t sent = send(socket_, from, size, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0 && errno != EAGAIN && errno != EINTR) {
      return false;
    }
    from += std::max<ssize_t>(sent, 0);
    size -= static_cast<size_t>(std::max<ssize_t>(sent, 0));
  }
  return size == 0;
}

bool Channel::SendOutput() {
  const std::string output = session_->TakeOutput();
  return SendRaw(output.data(), output.size());
}

bool Channel::ReceiveInput() {
  std::array<char, 16384> input;
  const std::ptrdiff_t received = ReceiveRaw(input.data(), input.size());
  if (received > 0) {
    session_->GiveInput({input.data(), static_cast<size_t>(received)});
  }
  return received > 0;
}

std::string Channel::Handshake() {
  while (true) {
    const TlsSession::Step step = session_->Handshake();
    const bool has_sent = SendOutput();  // An alert, too.
    if (step == TlsSession::Step::kDone) {
      return has_sent ? "" : "the connection broke during the TLS handshake";
    }
    if (step == TlsSession::Step::kFailed) {
      return session_->Explanation();
    }
    if (!has_sent || !ReceiveInput()) {
      return "the connection broke during the TLS handshake";
    }
  }
}

std::ptrdiff_t Channel::Receive(char* to, size_t size) {
  if (session_ == nullptr) {
    return ReceiveRaw(to, size);
  }
  while (true) {
    size_t num_read = 0;
    switch (session_->Read(to, size, &num_read)) {
      case TlsSession::Step::kDone:
        return static_cast<std::ptrdiff_t>(num_read);
      case TlsSession::Step::kFailed:
        return -1;
      case TlsSession::Step::kNeedsInput:
        if (!SendOutput() || !ReceiveInput()) {
          return -1;  // A stream that ends without the TLS farewell may have been cut.
        }
    }
  }
}

std::ptrdiff_t Channel::Send(const char* from, size_t size) {
  if (session_ == nullptr) {
    return SendRaw(from, size) ? static_cast<std::ptrdiff_t>(size) : -1;
  }
  return session_->Write({from, size}) && SendOutput() ? static_cast<std::ptrdiff_t>(size) : -1;
}

}  // namespace cairn
