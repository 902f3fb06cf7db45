#include "http/exchange/server_url.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

#include "core/error.h"
#include "core/printable.h"
#include "core/wire/header_line.h"

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

// Visible ASCII, which needs no escape in the first line of a request.
bool IsPath(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) {
    return c > ' ' && c <= '~' && c != '?' && c != '#' && c != '\\';
  });
}

// Moves what follows the authority of "authority/prefix/" to the URL.
bool SplitPrefix(std::string_view* authority, ServerUrl* url) {
  const size_t slash = std::min(authority->find('/'), authority->size());
  std::string_view prefix = authority->substr(slash);
  *authority = authority->substr(0, slash);
  while (prefix.ends_with('/')) {
    prefix.remove_suffix(1);
  }
  url->prefix = prefix;
  return IsPath(prefix);
}

bool StartsWithScheme(std::string_view url, std::string_view scheme) {
  return ToLowerAscii(url.substr(0, scheme.size())) == scheme;
}

}  // namespace

ServerUrl ParseServerUrl(const std::string& url) {
  ServerUrl parsed;
  std::string_view authority = url;
  parsed.is_secure = StartsWithScheme(authority, kSecure);
  const std::string_view scheme = parsed.is_secure ? kSecure : kPlain;
  parsed.port = parsed.is_secure ? kSecurePort : kPlainPort;
  if (StartsWithScheme(authority, scheme)) {
    authority.remove_prefix(scheme.size());
    if (SplitPrefix(&authority, &parsed) &&
        authority.find_first_of("?#@ \\\r\n\t") == std::string_view::npos &&
        SplitHostAndPort(authority, &parsed)) {
      return parsed;
    }
  }
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("{} is not a server address; write http://host:port, https://host:port, "
                          "or https://host/prefix if a front serves the API under a path",
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
