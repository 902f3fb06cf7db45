// The address of a server, as people write it.
#ifndef CAIRN_HTTP_EXCHANGE_SERVER_URL_H_
#define CAIRN_HTTP_EXCHANGE_SERVER_URL_H_

#include <string>

namespace cairn {

struct ServerUrl {
  bool is_secure = false;  // https
  std::string host;        // A name, an IPv4 address, or an IPv6 address without brackets.
  int port = 0;
  // The path under which a front serves the API, as "/vps", without a slash at its end; or empty.
  std::string prefix;
};

// Reads "http://host:port" or "https://host:port/prefix", the scheme in any case; without a port it
// is 80 or 443. An IPv6 address stands in brackets. Throws Error(kInvalidArgument) for anything
// else.
ServerUrl ParseServerUrl(const std::string& url);

// Returns true if what is sent to this host, a name or an address, does not leave the machine:
// "localhost", 127.0.0.0/8 and ::1.
bool IsLoopbackHost(const std::string& host);

}  // namespace cairn

#endif  // CAIRN_HTTP_EXCHANGE_SERVER_URL_H_
