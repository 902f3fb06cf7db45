// A connected socket, plain or with TLS, whose every call ends at a deadline.
#ifndef CAIRN_HTTP_EXCHANGE_CHANNEL_H_
#define CAIRN_HTTP_EXCHANGE_CHANNEL_H_

#include <chrono>
#include <cstddef>
#include <string>

#include "http/exchange/tls.h"

namespace cairn {

using ExchangeClock = std::chrono::steady_clock;

// Waits until the socket can be read or written. Returns false at the deadline.
bool WaitForSocket(int socket, short events, ExchangeClock::time_point deadline);

// Does not own the socket or the session. Not thread-safe. No call raises SIGPIPE.
class Channel {
 public:
  // `session` is null for a plain connection.
  Channel(int socket, TlsSession* session, ExchangeClock::time_point deadline)
      : socket_(socket), session_(session), deadline_(deadline) {}

  // Shakes hands. Returns an explanation if the server is not who it should be or time is over;
  // empty if all is well. Only with a session.
  std::string Handshake();

  // Returns the number of bytes, 0 at the end of the stream, or -1 after a failure.
  std::ptrdiff_t Receive(char* to, size_t size);
  std::ptrdiff_t Send(const char* from, size_t size);

  bool is_late() const { return is_late_; }  // A call has met the deadline.

 private:
  bool Wait(short events);
  std::ptrdiff_t ReceiveRaw(char* to, size_t size);
  bool SendRaw(const char* from, size_t size);
  bool SendOutput();    // What the session wants to send.
  bool ReceiveInput();  // Gives the session what comes next.

  int socket_;
  TlsSession* session_;
  ExchangeClock::time_point deadline_;
  bool is_late_ = false;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_EXCHANGE_CHANNEL_H_
