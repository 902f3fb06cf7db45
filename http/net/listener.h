// A bound port, the loop that holds its connections and the threads that answer its requests.
#ifndef CAIRN_HTTP_NET_LISTENER_H_
#define CAIRN_HTTP_NET_LISTENER_H_

#include <memory>
#include <string>

#include "http/net/connection.h"
#include "http/net/event_loop.h"
#include "http/net/message.h"
#include "http/wire/problem.h"

namespace cairn {

struct ListenerOptions {
  std::string host = "127.0.0.1";
  int port = 0;         // 0 picks a free one.
  int num_threads = 8;  // Requests that are worked on at once.
  ConnectionLimits connection = {};
  // Its max_connections is lowered to half of the files that the process may open.
  LoopLimits loop = {};
};

// What a listener serves. Called from many threads at once; throws nothing but std::bad_alloc,
// which the listener answers with 503.
class RequestHandler {
 public:
  virtual ~RequestHandler() = default;
  virtual HttpResponse Handle(const HttpRequest& request) = 0;
  // The answer to a request that was refused before it was complete. Must not block.
  virtual HttpResponse Refuse(const HttpError& error, const std::string& request_id) = 0;
};

// A thread sees a request when it is whole, and is free again when the answer is written, not when
// the client has read it. Start and Stop from one thread.
class Listener {
 public:
  // `handler` must outlive the listener.
  Listener(const ListenerOptions& options, RequestHandler* handler);
  ~Listener();  // Stops.

  // Binds and listens. Throws as ListenOn.
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
