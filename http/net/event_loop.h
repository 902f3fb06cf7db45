// The event loop of a port: accepts connections, reads their requests, sends the unsent parts of
// responses, and enforces the limits. At most one thread runs the loop at a time.
#ifndef CAIRN_HTTP_NET_EVENT_LOOP_H_
#define CAIRN_HTTP_NET_EVENT_LOOP_H_

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <vector>

#include "core/wire/problem.h"
#include "http/net/connection.h"
#include "http/net/connection_table.h"
#include "http/net/lead.h"

namespace cairn {

struct LoopLimits {
  // Open at once. A connection beyond the limit replaces one that waits for its client. If all
  // connections are being answered, the new one gets status 503.
  int max_connections = 1024;
  // Bytes of requests and responses in memory, summed over all connections. Above the limit, the
  // loop closes connections that wait for their clients. It spares clients that hold at most half
  // as much as the heaviest client, up to twice the limit.
  size_t max_buffered_bytes = size_t{256} << 20;
  // After Stop, the time allowed for partly received requests and for responses.
  std::chrono::milliseconds stop_timeout{5000};
};

// A whole request. The loop lends the connection to the thread that answers the request.
struct RequestJob {
  Connection* connection = nullptr;
  ReceivedRequest request;
};

// A connection uses no thread while it is idle, while its request arrives, and while its response
// is being sent. The loop closes connections when there are too many of them or when too much is in
// memory. It takes them from the client (Peer::network) that has most: with too many connections,
// the connection that has waited longest; with too many bytes, the one that has held most bytes for
// longest.
//
// The threads that answer requests take turns as the leader, which waits for the sockets. When a
// request is whole, the leader makes another thread the leader and answers the request itself. So a
// request changes threads as rarely as it would with one thread a connection (docs/decisions/0014).
class EventLoop {
 public:
  // Makes the response to a request that is refused before it is complete. Must not block or throw.
  using RefuseFunction =
      std::function<ResponseText(const Connection& connection, const HttpError& error)>;

  // The loop hands out at most `max_answering` requests at a time. Throws Error(kIo) if the system
  // cannot provide the resources that the loop needs.
  EventLoop(Socket listening, const ConnectionLimits& connection_limits,
            const LoopLimits& loop_limits, int max_answering, RefuseFunction refuse);
  ~EventLoop();

  // Returns the next whole request, in order of arrival. After Stop, returns nothing once all
  // connections have ended. Call it from `max_answering` + 1 threads, so that one thread is always
  // free to lead.
  std::optional<RequestJob> Next();

  // Returns the connection of a job to the loop, after Connection::Respond.
  void TakeBack(Connection* connection);

  // Closes the port and all idle connections. Requests that have begun may finish.
  void Stop();

 private:
  using Entry = ConnectionTable::Entry;
  using TimePoint = Connection::TimePoint;

  bool HasEnded() const { return is_closing_ && connections_.entries().empty(); }
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
  // Advances the connection again in the next round, without waiting for an event.
  void Postpone(Entry* entry);
  void AdvancePostponed();
  void Lend(Entry* entry);
  void Refuse(Entry* entry, const HttpError& error);
  void TakeBackAnswered();
  void Expire();
  TimePoint DeadlineOf(const Entry& entry) const;
  void BeginClosing();

  void Account(Entry* entry, size_t bytes);
  // Closes the connection to make room. False if `entry` is null.
  bool Drop(Entry* entry);
  // Logs how many connections were closed or not accepted, and why; at most once a second.
  void ReportShortage(const char* cause);

  Socket listening_;
  const ConnectionLimits connection_limits_;
  const LoopLimits limits_;
  const int max_answering_;
  const RefuseFunction refuse_;
  Socket epoll_;
  Socket wake_;  // An eventfd.

  Lead lead_;

  // Used by the leader only.
  ConnectionTable connections_;
  std::vector<Entry*> postponed_;
  std::deque<RequestJob> ready_;
  int num_answering_ = 0;
  TimePoint next_expiry_;  // No deadline is earlier than this.
  std::optional<TimePoint> accept_again_;
  bool is_closing_ = false;
  TimePoint closing_deadline_ = TimePoint::max();
  int64_t num_dropped_ = 0;  // Since the last report.
  TimePoint next_report_;

  std::atomic<bool> stop_requested_{false};
  std::mutex mutex_;  // Guards the next two members and Entry::has_event_while_lent.
  std::vector<Entry*> answered_;
  bool wake_when_answered_ = false;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_NET_EVENT_LOOP_H_
