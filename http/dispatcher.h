// Turns every request into a response, including requests that fail.
#ifndef CAIRN_HTTP_DISPATCHER_H_
#define CAIRN_HTTP_DISPATCHER_H_

#include <string>

#include "core/log_limiter.h"
#include "http/keys/key_ring.h"
#include "http/net/listener.h"
#include "http/router.h"
#include "http/service/access_log.h"
#include "http/service/metrics.h"

namespace cairn {

// Finds the route, asks for a key that may use it, runs its handler, counts the request, and adds
// the headers that all responses have. Turns every exception except std::bad_alloc into a problem.
// Safe to call from any thread.
class Dispatcher : public RequestHandler {
 public:
  // Without `keys`, all routes are open. What is not null must outlive the dispatcher.
  Dispatcher(Router router, Metrics* metrics, KeyRing* keys = nullptr,
             AccessLog* access_log = nullptr)
      : router_(std::move(router)), metrics_(metrics), keys_(keys), access_log_(access_log) {}

  const Router& router() const { return router_; }

  // On a server with keys, refuses an upload unless its route exists and its key may use the route
  // now. What is open to all takes no upload.
  void CheckHead(const RequestHead& head) override;
  HttpResponse Handle(HttpRequest request) override;
  HttpResponse Refuse(const HttpError& error, const RefusedRequest& request) override;

 private:
  // The outcome of a request, as metrics and logs see it.
  struct Outcome {
    std::string route_pattern;  // Empty if no route was found.
    const char* problem = "";   // The code of a refusal.
  };

  HttpResponse Run(HttpRequest* request, Outcome* outcome) const;
  // The label of the key that was known and refused by the head, or empty.
  std::string LabelOf(const HttpError& error, const RefusedRequest& request) const;
  // Lets the holder of a key use the route, and names the holder in the request.
  void Admit(const Route& route, HttpRequest* request) const;

  // Logs a failure of the server, unless there are too many. The metrics count all of them.
  void LogFailure(const HttpRequest& request, const std::string& route_pattern,
                  const char* what) const;

  mutable LogLimiter failures_;
  Router router_;
  Metrics* metrics_;
  KeyRing* keys_;
  AccessLog* access_log_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_DISPATCHER_H_
