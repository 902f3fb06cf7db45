// HTTP exchanges with a server that may be slow, broken or hostile.
#ifndef CAIRN_HTTP_EXCHANGE_BOUNDED_CLIENT_H_
#define CAIRN_HTTP_EXCHANGE_BOUNDED_CLIENT_H_

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cairn {

struct BoundedClientOptions {
  std::string url;  // As ParseServerUrl reads it, for example "http://host:port".
  // PEM file with the certificates to trust instead of the system's; only for https.
  std::string ca_file = {};
  // Sent with each request as "Authorization: Bearer"; empty: none. No message contains it.
  std::string api_key = {};
  // Without this, a key goes to other machines over https only: over plain http, everybody on the
  // way can read it and use it from then on.
  bool allow_plain_key = false;
  // For the whole exchange: connecting, TLS, the request and the response.
  int timeout_ms = 30'000;
  // Longest body of a response, as it is sent and as it is after decompression.
  size_t max_body_bytes = size_t{64} << 20;

  // Throws Error(kInvalidArgument) that names the field, also if the key may not go to the URL.
  void Validate() const;
};

struct ClientRequest {
  std::string method = "GET";
  std::string path;  // Begins with a slash; follows the prefix of the URL.
  std::vector<std::pair<std::string, std::string>> headers = {};
  std::string body = {};
};

struct ClientResponse {
  int status = 0;  // 0 if there is no complete response.
  std::vector<std::pair<std::string, std::string>> headers;
  std::string body;
  std::string failure;      // Why there is no complete response.
  bool is_garbled = false;  // It is missing because the server sent what no server should send.

  // Returns the first value of a header, whose name is compared without case; empty if missing.
  std::string Header(const std::string& name) const;

  // If there were too many requests (429): the number of seconds after which the next one may come,
  // by Retry-After. A date there counts from the response's own Date, or without one from the clock
  // of this machine. Nothing for other responses, and without such a header.
  std::optional<std::chrono::seconds> RetryAfter() const;
};

// cpp-httplib writes the request and reads the response. Its bytes pass a stream of Cairn that
// keeps the deadline and ends the exchange when a limit is exceeded (response_guard.h), before the
// library sees them. Redirects are not followed, so a key reaches no
// other host than that of the URL. The connection is kept alive. The names of hosts
// are resolved by the system, whose own time limit adds to the exchange's.
//
// Use a client from one thread only, apart from Stop.
class BoundedClient {
 public:
  // Throws the errors of Validate, ParseServerUrl and TlsContext.
  explicit BoundedClient(const BoundedClientOptions& options);
  ~BoundedClient();

  // Never throws for what the server does.
  ClientResponse Send(ClientRequest request);

  // Aborts the exchange under way. If its connection is just being made, waits for that, at most
  // `timeout_ms`.
  void Stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn

#endif  // CAIRN_HTTP_EXCHANGE_BOUNDED_CLIENT_H_
