#include "http/net/response_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>

namespace cairn {
namespace {

struct Phrase {
  int status;
  const char* text;
};

// Those of RFC 9110 and RFC 6585. The body of a refusal says more.
constexpr std::array kPhrases = {Phrase{200, "OK"},
                                 Phrase{204, "No Content"},
                                 Phrase{302, "Found"},
                                 Phrase{304, "Not Modified"},
                                 Phrase{400, "Bad Request"},
                                 Phrase{401, "Unauthorized"},
                                 Phrase{403, "Forbidden"},
                                 Phrase{404, "Not Found"},
                                 Phrase{405, "Method Not Allowed"},
                                 Phrase{408, "Request Timeout"},
                                 Phrase{409, "Conflict"},
                                 Phrase{411, "Length Required"},
                                 Phrase{413, "Content Too Large"},
                                 Phrase{414, "URI Too Long"},
                                 Phrase{415, "Unsupported Media Type"},
                                 Phrase{417, "Expectation Failed"},
                                 Phrase{429, "Too Many Requests"},
                                 Phrase{431, "Request Header Fields Too Large"},
                                 Phrase{500, "Internal Server Error"},
                                 Phrase{501, "Not Implemented"},
                                 Phrase{503, "Service Unavailable"},
                                 Phrase{505, "HTTP Version Not Supported"}};

const char* ReasonPhrase(int status) {
  const auto* const found =
      std::find_if(kPhrases.begin(), kPhrases.end(),
                   [status](const Phrase& phrase) { return phrase.status == status; });
  return found == kPhrases.end() ? "" : found->text;
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
