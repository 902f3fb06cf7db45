// A strict parser for the head of an HTTP/1.1 request. It follows RFC 9112 and also refuses chunked
// bodies, line folding and bare line feeds. It refuses any ambiguity about the length of the body,
// and any head beyond the limits, before allocating memory for the head or routing the request.
#ifndef CAIRN_HTTP_NET_REQUEST_HEAD_H_
#define CAIRN_HTTP_NET_REQUEST_HEAD_H_

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cairn {

// Limits of a head. Longer ones are refused.
inline constexpr size_t kMaxTargetBytes = 4096;
inline constexpr size_t kMaxHeadBytes = 16384;  // Request line and headers together.
inline constexpr size_t kMaxHeaders = 64;

struct RequestHead {
  std::string method;
  std::string target;  // As sent: percent-encoded, including the query.
  bool is_http_1_0 = false;
  std::vector<std::pair<std::string, std::string>> headers;  // Names in lower case.
  size_t content_length = 0;
  bool expects_continue = false;
  bool keep_alive = true;

  // First value of a header, or empty.
  std::string_view Header(std::string_view lower_case_name) const;
};

// `text` ends with the empty line and includes it. Throws HttpError with the status that RFC 9110
// assigns to the fault, also if the head announces a body of more than `max_body_bytes`.
RequestHead ParseRequestHead(std::string_view text, size_t max_body_bytes);

}  // namespace cairn

#endif  // CAIRN_HTTP_NET_REQUEST_HEAD_H_
