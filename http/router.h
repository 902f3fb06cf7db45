// Which handler answers which path and method.
#ifndef CAIRN_HTTP_ROUTER_H_
#define CAIRN_HTTP_ROUTER_H_

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "http/net/message.h"

namespace cairn {

// `path_parameter` is what stood for the {...} of the pattern, or empty.
using RouteHandler =
    std::function<HttpResponse(const HttpRequest& request, const std::string& path_parameter)>;

struct Route {
  std::string method;   // "GET" serves HEAD, too.
  std::string pattern;  // "/v1/tiles/{id}": at most one {...}, which stands for one whole segment.
  RouteHandler handler;
};

// Immutable once built; safe to call from any thread.
class Router {
 public:
  void Add(Route route) { routes_.push_back(std::move(route)); }
  const std::vector<Route>& routes() const { return routes_; }

  struct Match {
    const Route* route;  // Null for OPTIONS, which `allow` answers.
    std::string path_parameter;
    std::string allow;  // The methods of the path, for an Allow header.
  };

  // Throws HttpError kNotFound, or kMethodNotAllowed with an Allow header.
  Match Find(const HttpRequest& request) const;

 private:
  std::vector<Route> routes_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_ROUTER_H_
