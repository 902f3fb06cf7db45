#include "http/net/response_text.h"

#include <fmt/format.h>

#include <iterator>

#include "core/wire/problem.h"

namespace cairn {
namespace {

const char* ReasonPhrase(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 204:
      return "No Content";
    case 302:
      return "Found";
    case 304:
      return "Not Modified";
    default:
      break;
  }
  for (const ProblemInfo& problem : AllProblems()) {
    if (problem.status == status) {
      return problem.title;
    }
  }
  return "";
}

}  // namespace

ResponseText SerializeResponse(HttpResponse response, bool is_head,
                               std::optional<std::chrono::milliseconds> keep_alive) {
  ResponseText text;
  const auto out = std::back_inserter(text.head);
  fmt::format_to(out, "HTTP/1.1 {} {}\r\n", response.status, ReasonPhrase(response.status));
  for (const auto& [name, value] : response.headers) {
    fmt::format_to(out, "{}: {}\r\n", name, value);
  }
  if (!response.content_type.empty()) {
    fmt::format_to(out, "Content-Type: {}\r\n", response.content_type);
  }
  if (response.status != 204 && response.status != 304) {
    fmt::format_to(out, "Content-Length: {}\r\n", response.body.size());
  }
  text.head += keep_alive ? "Connection: keep-alive\r\n" : "Connection: close\r\n";
  if (keep_alive && *keep_alive >= std::chrono::seconds(1)) {
    fmt::format_to(out, "Keep-Alive: timeout={}\r\n", keep_alive->count() / 1000);
  }
  text.head += "\r\n";
  if (!is_head) {
    text.body = std::move(response.body);
  }
  return text;
}

}  // namespace cairn
