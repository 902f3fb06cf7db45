// A request and a response as handlers see them, free of library types.
#ifndef CAIRN_HTTP_NET_MESSAGE_H_
#define CAIRN_HTTP_NET_MESSAGE_H_

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace cairn {

// A complete, checked request: the head satisfies net/request_head.h, and the whole body is
// present.
struct HttpRequest {
  std::string method;                               // Upper case.
  std::string path;                                 // Percent-decoded, without the query.
  std::multimap<std::string, std::string> query;    // Percent-decoded.
  std::multimap<std::string, std::string> headers;  // Names in lower case.
  std::string body;
  std::string remote_address;
  // Equal for all requests of one client: of the address that a trusted front names, or else of the
  // other end of the connection (net/client_network.h).
  uint64_t client = 0;
  // The label of the API key that the request has shown to be valid; `client` is then its number
  // instead. Empty without such a key.
  std::string label = {};
  std::string request_id;                         // The client's id if usable, else made here.
  std::chrono::steady_clock::time_point arrival;  // When its last byte had been read.

  // The first value, or empty. `lower_case_name` has lower case, as the stored names do.
  const std::string& Header(const std::string& lower_case_name) const {
    static const std::string empty;
    const auto it = headers.find(lower_case_name);
    return it == headers.end() ? empty : it->second;
  }
};

struct HttpResponse {
  int status = 200;
  std::string content_type = {};  // Empty if the body is empty.
  std::string body = {};
  std::vector<std::pair<std::string, std::string>> headers = {};

  static HttpResponse Json(std::string json) {
    return {
        .status = 200, .content_type = "application/json", .body = std::move(json), .headers = {}};
  }
};

}  // namespace cairn

#endif  // CAIRN_HTTP_NET_MESSAGE_H_
