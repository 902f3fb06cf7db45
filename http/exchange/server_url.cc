#include "http/exchange/server_url.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <string_view>

#include "core/error.h"
#include "core/printable.h"

namespace cairn {
namespace {

constexpr std::string_view kPlain = "http://", kSecure = "https://";
constexpr int kPlainPort = 80, kSecurePort = 443;

std::optional<int> ParsePort(std::string_view text) {
  int port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (error != std::errc() || end != text.data() + text.size() || port < 1 || port > 65535) {
    return std::nullopt;
  }
  return port;
}

// Splits "host", "host:port", "[address]" and "[address]:port".
bool SplitHostAndPort(std::string_view authority, ServerUrl* url) {
  std::string_view rest;
  if (authority.starts_with('[')) {
    const size_t end = authority.find(']');
    if (end == std::string_view::npos) {
      return false;
    }
    url->host = authority.substr(1, end - 1);
    rest = authority.substr(end + 1);
  } else {
    const size_t colon = authority.find(':');
    url->host = authority.substr(0, colon);
    rest = colon == std::string_view::npos ? std::string_view() : authority.substr(colon);
  }
  if (rest.empty()) {
    return !url->host.empty();
  }
  const std::optional<int> port = rest.front() == ':' ? ParsePort(rest.substr(1)) : std::nullopt;
  url->port = port.value_or(0);
  return port && !url->host.empty();
}

}  // namespace

ServerUrl ParseServerUrl(const std::string& url) {
  ServerUrl parsed;
  std::string_view authority = url;
  parsed.is_secure = authority.starts_with(kSecure);
  const std::string_view scheme = parsed.is_secure ? kSecure : kPlain;
  parsed.port = parsed.is_secure ? kSecurePort : kPlainPort;
  if (authority.starts_with(scheme)) {
    authority.remove_prefix(scheme.size());
    if (authority.find_first_of("/?#@ \\\r\n\t") == std::string_view::npos &&
        SplitHostAndPort(authority, &parsed)) {
      return parsed;
    }
  }
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("{} is not a server address; write http://host:port or https://host:port",
                          Excerpt(url)));
}

bool IsLoopbackHost(const std::string& host) {
  in_addr ipv4{};
  in6_addr ipv6{};
  if (inet_pton(AF_INET, host.c_str(), &ipv4) == 1) {
    return (ntohl(ipv4.s_addr) >> 24) == 127;
  }
  return host == "localhost" ||
         (inet_pton(AF_INET6, host.c_str(), &ipv6) == 1 && IN6_IS_ADDR_LOOPBACK(&ipv6));
}

}  // namespace cairn
