// The request target: path and query.
#ifndef CAIRN_HTTP_NET_URL_H_
#define CAIRN_HTTP_NET_URL_H_

#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace cairn {

// Undoes percent-encoding; with `plus_is_space`, also turns '+' into a space. Returns nothing if an
// escape is malformed or encodes NUL.
std::optional<std::string> PercentDecode(std::string_view text, bool plus_is_space);

struct Target {
  std::string path;
  std::multimap<std::string, std::string> query;
};

// Splits and decodes "path?key=value&...". Returns nothing if an escape is malformed.
std::optional<Target> ParseTarget(std::string_view target);

}  // namespace cairn

#endif  // CAIRN_HTTP_NET_URL_H_
