// One TCP connection: the received part of its requests, the unsent part of its responses, and the
// deadline for the peer's next step.
#ifndef CAIRN_HTTP_NET_CONNECTION_H_
#define CAIRN_HTTP_NET_CONNECTION_H_

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "http/net/request_head.h"
#include "http/net/response_text.h"
#include "http/net/socket.h"

namespace cairn {

struct ConnectionLimits {
  size_t max_body_bytes = size_t{2} << 20;
  // How long a connection may be silent, before its first request and between requests.
  std::chrono::milliseconds idle_timeout{3000};
  // Limits for the head (from its first byte to its end) and for the body (from the end of the head
  // to the end of the body). They bound the resources that a client can hold by sending very
  // slowly.
  std::chrono::milliseconds head_timeout{5000};
  std::chrono::milliseconds body_timeout{15000};
  // The peer must take a whole response within `send_timeout`, plus one second for every
  // `min_send_bytes_per_s` of the response. A tile of 7 MB has about two minutes.
  std::chrono::milliseconds send_timeout{15000};
  int64_t min_send_bytes_per_s = 64 * 1024;
};

struct ReceivedRequest {
  RequestHead head;
  std::string body;
  std::chrono::steady_clock::time_point arrival;  // When the first byte arrived.
};

// Reads and writes without blocking. The owner waits for the socket (see event_loop.h) and calls
// Proceed when the socket is ready. Use a connection from one thread at a time.
class Connection {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  enum class Next {
    kWait,     // Wait for the socket or for the deadline.
    kRequest,  // TakeRequest returns a request; the caller must then call Respond.
    kClose,    // The peer has gone, or all responses have been sent.
  };

  // `limits` must outlive the connection.
  Connection(Socket socket, Peer peer, const ConnectionLimits* limits);

  // Record the readiness of the socket. The events are edge-triggered: report each one once.
  void NoteReadable() { is_readable_ = true; }
  void NotePeerFinished() { is_readable_ = peer_has_finished_ = true; }

  // Does all work that is possible now. Throws HttpError to refuse the received data; the caller
  // must then call Respond with the refusal.
  Next Proceed();

  // Call once after kRequest. The connection reads nothing more until the response has been sent.
  ReceivedRequest TakeRequest();

  // Queues a response and sends as much as the socket takes now; Proceed sends the rest. Without
  // `keep_alive`, the connection closes after the response, once the peer has had time to read it.
  void Respond(ResponseText text, bool keep_alive);

  // Call when the deadline has passed. Throws HttpError kRequestTimeout if a request was partly
  // received. Otherwise the caller closes the connection.
  void GiveUp() const;

  // The deadline for the peer's next step, and the time since when the peer could have taken it.
  TimePoint deadline() const { return deadline_; }
  TimePoint waiting_since() const { return waiting_since_; }
  // True if no byte of the next request has arrived and nothing is unsent.
  bool is_idle() const { return phase_ == Phase::kIdle; }
  bool has_served() const { return has_served_; }
  // True if a part of a response is unsent because the peer has not read enough.
  bool is_sending() const { return phase_ == Phase::kSending; }
  // True if Proceed may find work without a further event of the socket.
  bool has_more() const { return is_readable_ || !in_.empty() || is_sending(); }
  size_t buffered_bytes() const;
  const Peer& peer() const { return peer_; }
  Socket& socket() { return socket_; }

 private:
  enum class Phase { kIdle, kHead, kBody, kAnswering, kSending, kDraining };
  enum class Transfer { kDone, kBlocked, kBroken };

  void Enter(Phase phase, std::chrono::milliseconds time);
  // Searches the received bytes; returns true if they hold a whole request.
  bool FindRequest();
  bool FindHead();
  void AskForBody();
  Transfer ReadSome();
  Transfer SendSome();
  void FinishResponse();
  Next Drain();

  Socket socket_;
  const Peer peer_;
  const ConnectionLimits* limits_;
  Phase phase_ = Phase::kIdle;
  bool is_readable_ = true;  // Possibly; the next read finds out.
  bool peer_has_finished_ = false;
  bool has_served_ = false;
  bool keep_alive_ = true;
  TimePoint waiting_since_;
  TimePoint deadline_;

  std::string in_;           // Received but not yet consumed.
  size_t num_searched_ = 0;  // The end of the head does not begin in these first bytes of `in_`.
  ReceivedRequest request_;  // Valid, except for its body, once the end of the head has arrived.
  ResponseText out_;         // The first num_sent_ bytes of head and body have been sent.
  size_t num_sent_ = 0;
  size_t num_drained_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_NET_CONNECTION_H_
