#include "http/handlers/compact_response.h"

#include <fmt/format.h>

#include <utility>

#include "core/wire/fingerprint.h"
#include "http/net/gzip.h"

namespace cairn {
namespace {

constexpr size_t kMaxPlainBytes = 1400;  // Fits into one packet.

std::string TagOf(std::string_view body) {
  Fingerprint contents;
  contents.Add(body);
  // Weak, because the compressed and the plain body share the tag.
  return fmt::format("W/\"{:016x}\"", contents.value());
}

bool WantsGzip(const HttpRequest& request, size_t num_bytes) {
  return num_bytes > kMaxPlainBytes && AcceptsGzip(request.Header("accept-encoding"));
}

HttpResponse Unchanged(HttpResponse response) {
  response.status = 304;
  response.content_type.clear();
  response.body.clear();
  return response;
}

HttpResponse WithNegotiatedTag(HttpResponse response, const std::string& tag) {
  response.headers.emplace_back("Vary", "Accept-Encoding");
  return WithTag(std::move(response), tag);
}

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
  const std::string tag = TagOf(response.body);
  if (IsUnchanged(request, tag)) {
    response = Unchanged(std::move(response));
  } else if (WantsGzip(request, response.body.size())) {
    response.body = Gzip(response.body);
    response.headers.emplace_back("Content-Encoding", "gzip");
  }
  return WithNegotiatedTag(std::move(response), tag);
}

FixedBody::FixedBody(std::string_view body)
    : plain_(body), zipped_(Gzip(body, GzipEffort::kMost)), tag_(TagOf(body)) {}

HttpResponse FixedBody::AddTo(const HttpRequest& request, HttpResponse response) const {
  if (IsUnchanged(request, tag_)) {
    response = Unchanged(std::move(response));
  } else if (WantsGzip(request, plain_.size())) {
    response.body = zipped_;
    response.headers.emplace_back("Content-Encoding", "gzip");
  } else {
    response.body = plain_;
  }
  return WithNegotiatedTag(std::move(response), tag_);
}

}  // namespace cairn
