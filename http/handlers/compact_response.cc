#include "http/handlers/compact_response.h"

#include <fmt/format.h>

#include <utility>

#include "core/wire/fingerprint.h"
#include "http/net/gzip.h"

namespace cairn {
namespace {

constexpr size_t kMaxPlainBytes = 1400;  // Fits into one packet.

}  // namespace

bool IsUnchanged(const HttpRequest& request, std::string_view tag) {
  // Tags are compared weakly (RFC 9110 section 13.1.2).
  if (tag.starts_with("W/")) {
    tag.remove_prefix(2);
  }
  const std::string& known = request.Header("if-none-match");
  return known == "*" || known.find(tag) != std::string::npos;
}

HttpResponse WithTag(HttpResponse response, const std::string& tag) {
  response.headers.emplace_back("ETag", tag);
  response.headers.emplace_back("Cache-Control", "no-cache");  // Ask each time; the tag is cheap.
  return response;
}

HttpResponse Compact(const HttpRequest& request, HttpResponse response) {
  Fingerprint contents;
  contents.Add(response.body);
  // Weak, because the compressed and the plain body share the tag.
  const std::string tag = fmt::format("W/\"{:016x}\"", contents.value());
  if (IsUnchanged(request, tag)) {
    response.status = 304;
    response.content_type.clear();
    response.body.clear();
  } else if (response.body.size() > kMaxPlainBytes &&
             AcceptsGzip(request.Header("accept-encoding"))) {
    response.body = Gzip(response.body);
    response.headers.emplace_back("Content-Encoding", "gzip");
  }
  response.headers.emplace_back("Vary", "Accept-Encoding");
  return WithTag(std::move(response), tag);
}

}  // namespace cairn
