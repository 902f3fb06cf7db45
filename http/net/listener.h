// A bound port and the workers that answer on it. cpp-httplib is hidden behind it.
#ifndef CAIRN_HTTP_NET_LISTENER_H_
#define CAIRN_HTTP_NET_LISTENER_H_

#include <functional>
#include <memory>
#include <string>

#include "http/message.h"
#include "http/net/connection.h"
#include "http/problem.h"

namespace cairn {

struct ListenerOptions {
  std::string host = "127.0.0.1";
  int port = 0;         // 0 picks a free one.
  int num_threads = 8;  // A connection holds one of them while it is open.
  ConnectionLimits limits;
};

// What a listener serves. Called from many threads at once; throws nothing but std::bad_alloc,
// which the listener answers with 503.
class RequestHandler {
 public:
  virtual ~RequestHandler() = default;
  virtual HttpResponse Handle(const HttpRequest& request) = 0;
  // The answer to a request that was refused before it was complete.
  virtual HttpResponse Refuse(const HttpError& error, const std::string& request_id) = 0;
};

// cpp-httplib binds, accepts and runs the workers; reading requests and writing responses is done
// here (see request_head.h for why). Keeps connections alive, but an idle one gives its worker up
// as soon as another connection waits for it. Start and Stop from one thread.
class Listener {
 public:
  // `handler` must outlive the listener.
  Listener(const ListenerOptions& options, RequestHandler* handler);
  ~Listener();  // Stops.

  // Binds and listens. Throws Error(kConflict) naming the port if it is taken, Error(kIo) if the
  // system refuses otherwise (privileged port, foreign address).
  void Start();
  // Closes the port, lets running requests finish, joins all threads. Idempotent.
  void Stop();

  int port() const;  // Valid after Start.

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_NET_LISTENER_H_
