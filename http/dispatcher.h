// Turns every request into a response, including requests that fail.
#ifndef CAIRN_HTTP_DISPATCHER_H_
#define CAIRN_HTTP_DISPATCHER_H_

#include <string>

#include "core/log_limiter.h"
#include "http/net/listener.h"
#include "http/router.h"
#include "http/service/metrics.h"

namespace cairn {

// Finds the route, runs its handler, counts the request, and adds the headers that all responses
// have. Turns every exception except std::bad_alloc into a problem. Safe to call from any thread.
class Dispatcher : public RequestHandler {
 public:
  // `metrics` must outlive the dispatcher.
  Dispatcher(Router router, Metrics* metrics) : router_(std::move(router)), metrics_(metrics) {}

  const Router& router() const { return router_; }

  HttpResponse Handle(const HttpRequest& request) override;
  HttpResponse Refuse(const HttpError& error, const std::string& request_id) override;

 private:
  HttpResponse Run(const HttpRequest& request, std::string* route_pattern) const;

  // Logs a failure of the server, unless there are too many. The metrics count all of them.
  void LogFailure(const HttpRequest& request, const std::string& route_pattern,
                  const char* what) const;

  mutable LogLimiter failures_;
  Router router_;
  Metrics* metrics_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_DISPATCHER_H_
