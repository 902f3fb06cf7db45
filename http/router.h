// Maps a method and a path to a handler.
#ifndef CAIRN_HTTP_ROUTER_H_
#define CAIRN_HTTP_ROUTER_H_

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "http/keys/key_rights.h"
#include "http/net/message.h"

namespace cairn {

// `path_parameter` is the text that the pattern's {...} matched, or empty.
using RouteHandler =
    std::function<HttpResponse(const HttpRequest& request, const std::string& path_parameter)>;

// On a server with API keys, a key with any of these rights opens a route. Without any, the route
// is open to all. There is no default, so that nobody opens a route by saying nothing.
class RouteNeeds : public KeyRights {
 public:
  constexpr RouteNeeds(KeyRights rights) : KeyRights(rights) {}  // NOLINT: the same set.
  constexpr RouteNeeds(KeyRight right) : KeyRights(right) {}     // NOLINT: a set.
};

struct Route {
  std::string method;   // "GET" also serves HEAD.
  std::string pattern;  // "/v1/tiles/{id}": at most one {...}, which matches one whole segment.
  RouteNeeds needs;
  RouteHandler handler;
};

// Immutable once built; safe to call from any thread.
class Router {
 public:
  void Add(Route route) { routes_.push_back(std::move(route)); }
  const std::vector<Route>& routes() const { return routes_; }

  struct Match {
    const Route* route;  // Null for OPTIONS; the dispatcher answers OPTIONS from `allow`.
    std::string path_parameter;
    std::string allow;  // The methods that the path accepts, for an Allow header.
  };

  // Throws HttpError kNotFound, or kMethodNotAllowed with an Allow header.
  Match Find(const std::string& method, const std::string& path) const;

 private:
  std::vector<Route> routes_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_ROUTER_H_
