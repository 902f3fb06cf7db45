// All connections of a port: accepts them, reads their requests, sends what is left of answers, and
// keeps the limits. Never more than one thread does that.
#ifndef CAIRN_HTTP_NET_EVENT_LOOP_H_
#define CAIRN_HTTP_NET_EVENT_LOOP_H_

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

#include "http/net/connection.h"
#include "http/net/lead.h"
#include "http/wire/problem.h"

namespace cairn {

struct LoopLimits {
  // Open at once. One more ends one that waits for its client; if all are being answered, the new
  // one gets status 503.
  int max_connections = 1024;
  // Requests and answers in memory, of all connections together. Above it connections that wait
  // for their clients are ended.
  size_t max_buffered_bytes = size_t{256} << 20;
  // After Stop: how long requests that have begun to arrive, and answers, may take.
  std::chrono::milliseconds stop_timeout{5000};
};

// A whole request. The connection is lent to whoever answers it.
struct RequestJob {
  Connection* connection = nullptr;
  ReceivedRequest request;
};

// A connection costs no thread while it is idle, while its request arrives and while its answer is
// being sent. When there are too many, or too much is in memory, those who have most give way: of
// the client (Peer::network) with most connections the one that has waited longest for it, or of
// the client with most bytes the one that has held most for longest.
//
// The threads that answer take turns as the leader, which waits for the sockets; when a request is
// whole, the leader makes another thread the leader and answers the request itself. So a request
// changes hands as seldom as if each connection had a thread (docs/decisions/0014).
class EventLoop {
 public:
  // The answer to a request that is refused before it is complete. Must not block or throw.
  using RefuseFunction = std::function<ResponseText(const HttpError& error)>;

  // Not more than `max_answering` requests are given out at a time. Throws Error(kIo) if the system
  // does not give what a loop needs.
  EventLoop(Socket listening, const ConnectionLimits& connection_limits,
            const LoopLimits& loop_limits, int max_answering, RefuseFunction refuse);
  ~EventLoop();

  // The next whole request, those that came first before others; nothing after Stop, when all
  // connections have ended. To be called from one thread more than `max_answering`, so that one is
  // left to lead.
  std::optional<RequestJob> Next();

  // Gives back the connection of a job after Connection::Respond.
  void TakeBack(Connection* connection);

  // Closes the port and all idle connections; what has begun may end.
  void Stop();

 private:
  struct Entry;
  using TimePoint = Connection::TimePoint;

  // What one client (Peer::network) has.
  struct Usage {
    int num_connections = 0;
    size_t bytes = 0;
  };

  bool HasEnded() const { return is_closing_ && entries_.empty(); }
  std::optional<RequestJob> TakeReady();
  // Waits for events and handles them.
  void RunRound();
  int WaitMs();
  void HandleEvent(uint32_t events, Entry* entry);
  void Wake();

  void AcceptSome();
  void Adopt(Socket socket, Peer peer);
  void HandleAcceptError(int error);
  void PauseAccepting();
  void ResumeAccepting();

  void Advance(Entry* entry);
  void Lend(Entry* entry);
  void Refuse(Entry* entry, const HttpError& error);
  void TakeBackAnswered();
  void Expire();
  TimePoint DeadlineOf(const Entry& entry) const;
  void BeginClosing();

  void Account(Entry* entry, size_t bytes);
  bool DropMostConnections();
  bool DropMostBytes();
  // The connection, among those that wait for their clients, with the highest rank.
  template <typename Rank>
  Entry* Foremost(const Rank& rank) const;
  void Drop(Entry* entry);
  // Ends it; its memory is freed when the events of this round are through.
  void Close(Entry* entry);
  // Logs why connections were ended or not accepted, and how many; at most once a second.
  void ReportShortage(const char* cause);

  Socket listening_;
  const ConnectionLimits connection_limits_;
  const LoopLimits limits_;
  const int max_answering_;
  const RefuseFunction refuse_;
  Socket epoll_;
  Socket wake_;  // An eventfd.

  Lead lead_;

  // The leader only.
  std::vector<std::unique_ptr<Entry>> entries_;
  std::vector<std::unique_ptr<Entry>> closed_;
  std::unordered_map<uint64_t, Usage> usage_;
  size_t buffered_bytes_ = 0;
  std::deque<RequestJob> ready_;
  int num_answering_ = 0;
  TimePoint next_expiry_;  // No deadline is earlier.
  std::optional<TimePoint> accept_again_;
  bool is_closing_ = false;
  TimePoint closing_deadline_ = TimePoint::max();
  int64_t num_dropped_ = 0;  // Since the last report.
  TimePoint next_report_;

  std::atomic<bool> stop_requested_{false};
  std::mutex mutex_;  // Of the next two, and of Entry::has_event_while_lent.
  std::vector<Entry*> answered_;
  bool wake_when_answered_ = false;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_NET_EVENT_LOOP_H_
