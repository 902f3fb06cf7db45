// One TCP connection: what has arrived of its requests, what is unsent of its answers, and by when
// the peer has to go on.
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
  HeadLimits head;
  // How long a connection may be silent before its first request and between requests.
  std::chrono::milliseconds idle_timeout{3000};
  // From the first byte of a head to its end, and from there to the end of the body. They bound
  // what a client that drips bytes can hold.
  std::chrono::milliseconds head_timeout{5000};
  std::chrono::milliseconds body_timeout{15000};
  // A whole answer has to be taken within `send_timeout`, plus a second for each
  // `min_send_bytes_per_s` of it: a tile of 7 MB has about two minutes.
  std::chrono::milliseconds send_timeout{15000};
  int64_t min_send_bytes_per_s = 64 * 1024;
};

struct ReceivedRequest {
  RequestHead head;
  std::string body;
  std::chrono::steady_clock::time_point arrival;  // Of its first byte.
};

// Reads and writes without waiting; whoever owns it waits for the socket (see event_loop.h) and
// calls Proceed when there is something to do. One thread at a time.
class Connection {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  enum class Next {
    kWait,     // For the socket or for the deadline.
    kRequest,  // TakeRequest has one, and Respond is due.
    kClose,    // The peer is gone, or everything is said.
  };

  // `limits` must outlive the connection.
  Connection(Socket socket, Peer peer, const ConnectionLimits* limits);

  // Note what the socket is ready for. Edges: each is to be told once.
  void NoteReadable() { is_readable_ = true; }
  void NotePeerFinished() { is_readable_ = peer_has_finished_ = true; }

  // Does what can be done now. Throws HttpError if what arrives is refused; Respond with its answer
  // is due then.
  Next Proceed();

  // After kRequest, once. Nothing more is read until the answer has been sent.
  ReceivedRequest TakeRequest();

  // Queues an answer and sends what the socket takes at once; Proceed sends the rest. Without
  // `keep_alive` the connection ends after it, but not before the peer had time to read it.
  void Respond(ResponseText text, bool keep_alive);

  // The deadline has passed. Throws HttpError kRequestTimeout if a request was on its way;
  // otherwise the connection is to be closed.
  void GiveUp() const;

  // By when the peer has to do its part, and since when it could have.
  TimePoint deadline() const { return deadline_; }
  TimePoint waiting_since() const { return waiting_since_; }
  // No byte of a request has come, or of the next one, and nothing is unsent.
  bool is_idle() const { return phase_ == Phase::kIdle; }
  bool has_served() const { return has_served_; }
  // A part of an answer is still with us, as the peer has not read enough.
  bool is_sending() const { return phase_ == Phase::kSending; }
  // Proceed may find something to do without a further event of the socket.
  bool has_more() const { return is_readable_ || !in_.empty() || is_sending(); }
  size_t buffered_bytes() const;
  const Peer& peer() const { return peer_; }
  Socket& socket() { return socket_; }

 private:
  enum class Phase { kIdle, kHead, kBody, kAnswering, kSending, kDraining };
  enum class Transfer { kDone, kBlocked, kBroken };

  void Enter(Phase phase, std::chrono::milliseconds time);
  // Looks at what has arrived; true if a request is whole.
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
  bool is_readable_ = true;  // Perhaps; the next read tells.
  bool peer_has_finished_ = false;
  bool has_served_ = false;
  bool keep_alive_ = true;
  TimePoint waiting_since_;
  TimePoint deadline_;

  std::string in_;           // Received and not yet consumed.
  size_t num_searched_ = 0;  // Bytes of `in_` in which the end of the head does not begin.
  ReceivedRequest request_;  // All but its body, from the end of its head on.
  ResponseText out_;         // The first num_sent_ bytes of head and body are gone.
  size_t num_sent_ = 0;
  size_t num_drained_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_NET_CONNECTION_H_
