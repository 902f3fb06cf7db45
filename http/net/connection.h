// One TCP connection: the received part of its requests, the unsent part of its responses, and the
// deadline for the peer's next step.
#ifndef CAIRN_HTTP_NET_CONNECTION_H_
#define CAIRN_HTTP_NET_CONNECTION_H_

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "http/net/request_head.h"
#include "http/net/response_text.h"
#include "http/net/socket.h"

namespace cairn {

struct ConnectionLimits {
  size_t max_body_bytes = size_t{2} << 20;
  // How long a connection may be silent, before its first request and between requests. Responses
  // state this time (Keep-Alive). Longer than the fronts and pools that reuse a connection after 60
  // s of silence; nginx has the same default.
  std::chrono::milliseconds idle_timeout{75'000};
  // Time for the head, from its first byte to its end. Bounds the resources that a client can hold
  // by sending very slowly.
  std::chrono::milliseconds head_timeout{5000};
  // A body may be silent for `body_timeout`. A body that comes more slowly than
  // `min_body_bytes_per_s` uses this time up; a faster one regains it. The rate is that of a phone
  // on the weakest link that still carries photos (EDGE, 32 kbit/s).
  std::chrono::milliseconds body_timeout{15000};
  int64_t min_body_bytes_per_s = 4 * 1024;
  // The peer must take a whole response within `send_timeout`, plus one second for every
  // `min_send_bytes_per_s` of the response. A tile of 7 MB has about two minutes.
  std::chrono::milliseconds send_timeout{15000};
  int64_t min_send_bytes_per_s = 64 * 1024;
  // Proceed reads about this much in one call, so that a client that sends without a pause cannot
  // keep the event loop from its other connections. About 50 microseconds.
  int64_t max_bytes_a_pass = 256 * 1024;
  // Looks at the head of a request whose body is still to come. Throws HttpError to refuse the
  // request before its body is read. Runs in the event loop, so it must not block.
  std::function<void(const RequestHead& head)> check_head = {};
};

struct ReceivedRequest {
  RequestHead head;
  std::string body;
  std::chrono::steady_clock::time_point arrival;  // When the last byte had been read.
};

// Reads and writes without blocking. The owner waits for the socket (see event_loop.h) and calls
// Proceed when the socket is ready. Use a connection from one thread at a time.
class Connection {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  enum class Next {
    kWait,     // Wait for the socket or for the deadline.
    kMore,     // Call Proceed again, once the other connections have had their turn.
    kRequest,  // TakeRequest returns a request; the caller must then call Respond.
    kClose,    // The peer has gone, or all responses have been sent.
  };

  // `limits` must outlive the connection.
  Connection(Socket socket, Peer peer, const ConnectionLimits* limits);

  // Record the readiness of the socket. The events are edge-triggered: report each one once.
  void NoteReadable() { is_readable_ = true; }
  void NotePeerFinished() { is_readable_ = peer_has_finished_ = true; }

  // Does the work that is possible now, within `max_bytes_a_pass`. Throws HttpError to refuse the
  // received data; the caller must then call Respond with the refusal.
  Next Proceed();

  // Call once after kRequest. The connection reads nothing more until the response has been sent.
  ReceivedRequest TakeRequest();

  // Queues a response and sends as much as the socket takes now; Proceed sends the rest. Without
  // `keep_alive`, the connection closes after the response, once the peer has had time to read it.
  void Respond(ResponseText text, bool keep_alive);

  // Call when the deadline has passed, or a server that stops waits no longer. If a request was
  // partly received, throws HttpError kRequestTimeout in the first case and kUnavailable in the
  // second. Otherwise the caller closes the connection.
  void GiveUp() const;

  // The deadline for the peer's next step, and the time since when the peer could have taken it.
  TimePoint deadline() const { return deadline_; }
  TimePoint waiting_since() const { return waiting_since_; }
  // True while a body comes, or bytes behind the last response. The socket then reports nothing
  // until a batch of bytes has come, so report it as readable once more before GiveUp.
  bool waits_for_batch() const { return phase_ == Phase::kBody || phase_ == Phase::kDraining; }
  // True if no byte of the next request has arrived and nothing is unsent.
  bool is_idle() const { return phase_ == Phase::kIdle; }
  bool has_served() const { return has_served_; }
  // True if a part of a response is unsent because the peer has not read enough.
  bool is_sending() const { return phase_ == Phase::kSending; }
  // True if Proceed may find work without a further event of the socket.
  bool has_more() const { return is_readable_ || !in_.empty() || is_sending(); }
  size_t buffered_bytes() const;
  const Peer& peer() const { return peer_; }
  // The head of the request that is being received; its method is empty before it has arrived.
  const RequestHead& head() const { return request_.head; }
  Socket& socket() { return socket_; }

 private:
  enum class Phase { kIdle, kHead, kBody, kAnswering, kSending, kDraining };
  enum class Transfer { kDone, kBlocked, kBroken };

  void Enter(Phase phase, std::chrono::milliseconds time);
  // Searches the received bytes; returns true if they hold a whole request.
  bool FindRequest();
  bool FindHead();
  void SkipEmptyLines();
  Transfer ReadSome();
  // Lets the socket become readable only once this many bytes have come.
  void ExpectBytes(size_t num_bytes);
  void ExpectBody();
  // Extends the deadline of the body after `num_bytes` more have arrived.
  void RewardBody(int64_t num_bytes);
  // Counts bytes that arrived after the last response, and gives the peer more time for others.
  void RewardDraining(int64_t num_bytes);
  Transfer SendSome();
  void FinishResponse();
  Next Drain();

  Socket socket_;
  const Peer peer_;
  const ConnectionLimits* limits_;
  Phase phase_ = Phase::kIdle;
  bool is_readable_ = true;  // Possibly; the next read finds out.
  bool peer_has_finished_ = false;
  size_t num_expected_bytes_ = 1;  // See ExpectBytes.
  bool has_served_ = false;
  bool keep_alive_ = true;
  TimePoint waiting_since_;
  TimePoint deadline_;

  int64_t budget_bytes_ = 0;    // What this pass may still read.
  size_t num_empty_bytes_ = 0;  // Of empty lines before the request.
  std::string in_;              // Received but not yet consumed.
  size_t num_searched_ = 0;     // The end of the head does not begin in these first bytes of `in_`.
  ReceivedRequest request_;     // Valid, except for its body, once the end of the head has arrived.
  ResponseText out_;            // The first num_sent_ bytes of head and body have been sent.
  size_t num_sent_ = 0;
  size_t num_drained_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_NET_CONNECTION_H_
