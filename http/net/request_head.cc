#include "http/net/request_head.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <utility>

#include "core/wire/accept.h"
#include "core/wire/header_line.h"
#include "core/wire/problem.h"

namespace cairn {
namespace {

constexpr std::array<std::string_view, 8> kMethods = {"GET",    "HEAD",    "POST",  "PUT",
                                                      "DELETE", "OPTIONS", "PATCH", "TRACE"};

[[noreturn]] void Refuse(ProblemCode code, const std::string& detail) {
  throw HttpError(code, detail);
}

// True for visible ASCII, the only characters allowed in a target, except '#'. Fragments are no
// part of a target (RFC 9112 section 3.2), and a front may take "/metrics#a" for another path.
bool IsTargetChar(char c) { return c > ' ' && c <= '~' && c != '#'; }

// Removes and returns the first line of `rest`, without its CRLF.
std::string_view TakeLine(std::string_view* rest) {
  const size_t end = rest->find("\r\n");
  if (end == std::string_view::npos) {
    Refuse(ProblemCode::kBadRequest, "a line has no end");
  }
  const std::string_view line = rest->substr(0, end);
  rest->remove_prefix(end + 2);
  return line;
}

// The path and query of a target that names scheme and host, as clients of a proxy send it: a
// server must accept that form (RFC 9112 section 3.2.2). Other targets stay as they are.
std::string OriginForm(std::string_view target) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (ToLowerAscii(target.substr(0, scheme.size())) == scheme) {
      const size_t end = target.find_first_of("/?", scheme.size());
      const std::string_view rest = end == std::string_view::npos ? "" : target.substr(end);
      return (rest.starts_with('/') ? "" : "/") + std::string(rest);
    }
  }
  return std::string(target);
}

void ParseRequestLine(std::string_view line, RequestHead* head) {
  const size_t first = line.find(' ');
  const size_t last = line.rfind(' ');
  if (first == std::string_view::npos || last == first) {
    Refuse(ProblemCode::kBadRequest, "the request line is not 'METHOD target HTTP/1.1'");
  }
  head->method = line.substr(0, first);
  head->target = line.substr(first + 1, last - first - 1);
  const std::string_view version = line.substr(last + 1);
  if (!IsToken(head->method)) {
    Refuse(ProblemCode::kBadRequest, "the method is not a token");
  }
  if (std::find(kMethods.begin(), kMethods.end(), head->method) == kMethods.end()) {
    Refuse(ProblemCode::kNotImplemented, "the method is unknown to this server");
  }
  if (head->target.size() > kMaxTargetBytes) {
    Refuse(ProblemCode::kUriTooLong,
           fmt::format("the target is longer than {} bytes", kMaxTargetBytes));
  }
  head->target = OriginForm(head->target);
  if (!head->target.starts_with('/') ||
      !std::all_of(head->target.begin(), head->target.end(), IsTargetChar)) {
    Refuse(ProblemCode::kBadRequest,
           "the target is not a path of visible ASCII characters without '#'; percent-encode the "
           "rest");
  }
  if (version != "HTTP/1.1" && version != "HTTP/1.0") {
    const bool is_http = version.starts_with("HTTP/");
    Refuse(is_http ? ProblemCode::kVersionNotSupported : ProblemCode::kBadRequest,
           "this server speaks HTTP/1.1");
  }
  head->is_http_1_0 = version == "HTTP/1.0";
}

void ParseHeaderLine(std::string_view line, RequestHead* head) {
  std::optional<HeaderLine> header = SplitHeaderLine(line);
  if (!header) {
    Refuse(ProblemCode::kBadRequest,
           "a header line is not 'Name: value', or has a control character");
  }
  head->headers.emplace_back(std::move(header->name), header->value);
}

// The value of a header that may occur at most once.
std::string_view SingleHeader(const RequestHead& head, std::string_view name) {
  const auto is_name = [&](const auto& header) { return header.first == name; };
  if (std::count_if(head.headers.begin(), head.headers.end(), is_name) > 1) {
    Refuse(ProblemCode::kBadRequest, fmt::format("more than one {} header", name));
  }
  return head.Header(name);
}

bool Has(const RequestHead& head, std::string_view name) {
  return std::any_of(head.headers.begin(), head.headers.end(),
                     [&](const auto& header) { return header.first == name; });
}

// True if the lists in the headers of this name contain the token, in any case.
bool ListNames(const RequestHead& head, std::string_view name, std::string_view token) {
  for (const auto& [header, value] : head.headers) {
    if (header != name) {
      continue;
    }
    for (std::string_view rest = value; !rest.empty();) {
      if (ToLowerAscii(TrimBlanks(TakeElement(&rest))) == token) {
        return true;
      }
    }
  }
  return false;
}

bool TakesBody(const std::string& method) {
  return method == "POST" || method == "PUT" || method == "PATCH";
}

size_t ParseContentLength(std::string_view text, size_t max_body_bytes) {
  size_t length = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), length);
  const bool is_number = !text.empty() && end == text.data() + text.size();
  if (error == std::errc::result_out_of_range || (is_number && length > max_body_bytes)) {
    throw HttpError(ProblemCode::kPayloadTooLarge,
                    fmt::format("the body is larger than {} bytes", max_body_bytes))
        .Hint("send features instead of an image, fewer features, or descriptors as bytes");
  }
  if (!is_number || error != std::errc()) {
    Refuse(ProblemCode::kBadRequest, "Content-Length is not a number");
  }
  return length;
}

void CheckBodyFraming(size_t max_body_bytes, RequestHead* head) {
  const bool has_length = Has(*head, "content-length");
  const std::string_view length = SingleHeader(*head, "content-length");
  if (Has(*head, "transfer-encoding")) {
    if (has_length) {
      Refuse(ProblemCode::kBadRequest, "the request has both Content-Length and Transfer-Encoding");
    }
    throw HttpError(ProblemCode::kLengthRequired, "chunked bodies are not accepted")
        .Hint("send the body with a Content-Length");
  }
  if (!has_length && TakesBody(head->method)) {
    Refuse(ProblemCode::kLengthRequired, "the request has no Content-Length");
  }
  const std::string encoding = ToLowerAscii(SingleHeader(*head, "content-encoding"));
  if (!encoding.empty() && encoding != "identity") {
    throw HttpError(ProblemCode::kUnsupportedEncoding, "compressed bodies are not accepted")
        .Hint("send the body without Content-Encoding");
  }
  if (has_length) {
    head->content_length = ParseContentLength(length, max_body_bytes);
  }
}

void ReadConnectionHeaders(RequestHead* head) {
  if (!head->is_http_1_0 && !Has(*head, "host")) {
    Refuse(ProblemCode::kBadRequest, "the request has no Host header");
  }
  SingleHeader(*head, "host");
  SingleHeader(*head, "content-type");
  head->keep_alive = !ListNames(*head, "connection", "close") &&
                     (!head->is_http_1_0 || ListNames(*head, "connection", "keep-alive"));
  const std::string expect = ToLowerAscii(SingleHeader(*head, "expect"));
  if (!expect.empty() && expect != "100-continue") {
    Refuse(ProblemCode::kExpectationFailed, "this server knows only the expectation 100-continue");
  }
  head->expects_continue = !expect.empty();
}

}  // namespace

std::string_view RequestHead::Header(std::string_view lower_case_name) const {
  for (const auto& [name, value] : headers) {
    if (name == lower_case_name) {
      return value;
    }
  }
  return {};
}

RequestHead ParseRequestHead(std::string_view text, size_t max_body_bytes) {
  RequestHead head;
  std::string_view rest = text;
  ParseRequestLine(TakeLine(&rest), &head);
  for (std::string_view line = TakeLine(&rest); !line.empty(); line = TakeLine(&rest)) {
    if (head.headers.size() == kMaxHeaders) {
      Refuse(ProblemCode::kHeadersTooLarge, fmt::format("more than {} header lines", kMaxHeaders));
    }
    ParseHeaderLine(line, &head);
  }
  ReadConnectionHeaders(&head);
  CheckBodyFraming(max_body_bytes, &head);
  return head;
}

}  // namespace cairn
