// One accepted TCP connection: reads whole requests within bounds of size and time.
#ifndef CAIRN_HTTP_NET_CONNECTION_H_
#define CAIRN_HTTP_NET_CONNECTION_H_

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "http/net/request_head.h"

namespace cairn {

struct ConnectionLimits {
  HeadLimits head;
  // How long a kept connection may be silent between requests. Short, because it holds a worker.
  std::chrono::milliseconds idle_timeout{3000};
  // From the first byte of a head to its end, and from there to the end of the body. Bounds what a
  // client that drips bytes can hold.
  std::chrono::milliseconds head_timeout{5000};
  std::chrono::milliseconds body_timeout{15000};
};

struct ReceivedRequest {
  RequestHead head;
  std::string body;
  std::chrono::steady_clock::time_point arrival;  // Of its first byte.
};

// Owns neither the socket nor its closing. One thread.
class Connection {
 public:
  // `give_up_idle` is asked while the connection is idle: true ends it early (a new connection not
  // before its first byte had time to come).
  Connection(int socket, const ConnectionLimits& limits, std::function<bool()> give_up_idle);

  // The next request; nothing if the peer closed, fell silent between requests, or left in the
  // middle of one. Throws HttpError if what arrives is refused; the connection cannot be used for
  // another request then.
  std::optional<ReceivedRequest> ReadRequest();

  // Sends all of it; false if the peer is gone or does not read.
  bool Send(std::string_view bytes);

  // Says that no more will be sent and swallows what the peer still sends, for a short while, so
  // that it can read the answer: closing on unread data would reset the connection.
  void FinishSending();

 private:
  using TimePoint = std::chrono::steady_clock::time_point;
  enum class ReadResult { kData, kClosed, kTimeout };

  ReadResult ReadSome(TimePoint deadline);
  bool WaitForFirstByte();
  std::optional<size_t> ReadHead();  // Length of the head, in buffer_.
  bool ReadBody(size_t num_bytes);

  int socket_;
  ConnectionLimits limits_;
  std::function<bool()> give_up_idle_;
  std::string buffer_;  // Received and not yet consumed.
  bool is_new_ = true;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_NET_CONNECTION_H_
