#include "http/router.h"

#include <fmt/format.h>

#include <optional>

#include "core/wire/problem.h"

namespace cairn {
namespace {

// The text that the pattern's parameter matches ("" without parameter). Returns nothing if the path
// does not match the pattern.
std::optional<std::string> MatchPattern(std::string_view pattern, std::string_view path) {
  const size_t open = pattern.find('{');
  if (open == std::string_view::npos) {
    return pattern == path ? std::optional<std::string>("") : std::nullopt;
  }
  const std::string_view prefix = pattern.substr(0, open);
  const std::string_view suffix = pattern.substr(pattern.find('}') + 1);
  if (path.size() <= prefix.size() + suffix.size() || !path.starts_with(prefix) ||
      !path.ends_with(suffix)) {
    return std::nullopt;
  }
  const std::string_view segment =
      path.substr(prefix.size(), path.size() - prefix.size() - suffix.size());
  if (segment.find('/') != std::string_view::npos) {
    return std::nullopt;
  }
  return std::string(segment);
}

}  // namespace

Router::Match Router::Find(const std::string& sent_method, const std::string& path) const {
  Match match{.route = nullptr, .path_parameter = "", .allow = ""};
  const std::string method = sent_method == "HEAD" ? "GET" : sent_method;
  for (const Route& route : routes_) {
    const std::optional<std::string> parameter = MatchPattern(route.pattern, path);
    if (!parameter) {
      continue;
    }
    match.allow += match.allow.empty() ? "" : ", ";
    match.allow += route.method == "GET" ? "GET, HEAD" : route.method;
    if (route.method == method) {
      match.route = &route;
      match.path_parameter = *parameter;
    }
  }
  if (match.allow.empty()) {
    throw HttpError(ProblemCode::kNotFound,
                    fmt::format("this server has no '{}'", path.substr(0, 128)))
        .Hint("GET /openapi.json lists all paths");
  }
  match.allow += ", OPTIONS";
  if (match.route == nullptr && method != "OPTIONS") {
    throw HttpError(ProblemCode::kMethodNotAllowed,
                    fmt::format("{} is not allowed for this path", sent_method))
        .Header("Allow", match.allow)
        .Hint("allowed: " + match.allow);
  }
  return match;
}

}  // namespace cairn
