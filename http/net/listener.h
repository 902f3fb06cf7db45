// A bound port, the event loop of its connections, and the threads that answer its requests.
#ifndef CAIRN_HTTP_NET_LISTENER_H_
#define CAIRN_HTTP_NET_LISTENER_H_

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/wire/problem.h"
#include "http/net/client_network.h"
#include "http/net/connection.h"
#include "http/net/event_loop.h"
#include "http/net/message.h"

namespace cairn {

struct ListenerOptions {
  std::string host = "127.0.0.1";
  int port = 0;         // 0 picks a free one.
  int num_threads = 8;  // Requests handled at the same time.
  TrustedFronts trusted_fronts = {};
  ConnectionLimits connection = {};
  // Start lowers `loop.max_connections` to at most half of the files that the process may open.
  LoopLimits loop = {};
};

// What is known of a request that is refused before it is complete.
struct RefusedRequest {
  std::string request_id;
  std::string remote_address;  // As HttpRequest::remote_address.
  std::string method;          // Empty, like the target, if the head is missing or malformed.
  std::string target;          // As RequestHead::target.
  std::vector<std::pair<std::string, std::string>> headers = {};  // As RequestHead::headers.
};

// The application behind a listener. The listener calls it from many threads at once. `Handle` and
// `Refuse` throw nothing but std::bad_alloc, to which the listener responds with 503.
class RequestHandler {
 public:
  virtual ~RequestHandler() = default;
  // Throws HttpError to refuse a request by its head, before its body is read. Must not block.
  virtual void CheckHead(const RequestHead& /*head*/) {}
  virtual HttpResponse Handle(HttpRequest request) = 0;
  // Makes the response to a request that is refused before it is complete. Must not block.
  virtual HttpResponse Refuse(const HttpError& error, const RefusedRequest& request) = 0;
};

// A thread receives a request when the request is whole. The thread is free again when the response
// is written, before the client has read it. Call Start and Stop from the same thread.
class Listener {
 public:
  // `handler` must outlive the listener.
  Listener(const ListenerOptions& options, RequestHandler* handler);
  ~Listener();  // Calls Stop.

  // Binds and listens. Throws as ListenOn.
  void Start();
  // From now on, closes every connection after its response. The port stays open, so clients can
  // connect again; behind a front, they come to another server. Call it between Start and Stop.
  void Drain();
  // Closes the port, lets running requests finish, and joins all threads. Idempotent.
  void Stop();

  int port() const;  // Valid after Start.

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_NET_LISTENER_H_
