// The key that a request presents.
#ifndef CAIRN_HTTP_KEYS_PRESENTED_KEY_H_
#define CAIRN_HTTP_KEYS_PRESENTED_KEY_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cairn {

// Takes the values of all headers `Authorization` and `X-API-Key`. Returns the key of "Bearer KEY"
// (RFC 6750) or of X-API-Key, or nothing if there is none: another scheme is somebody else's, such
// as that of a front. Throws HttpError kUnauthorized if there are several keys.
std::optional<std::string> PresentedKey(const std::vector<std::string_view>& authorization,
                                        const std::vector<std::string_view>& x_api_key);

// The same for headers whose names are in lower case.
template <typename Headers>
std::optional<std::string> PresentedKey(const Headers& headers) {
  std::vector<std::string_view> authorization, x_api_key;
  for (const auto& [name, value] : headers) {
    if (name == "authorization") {
      authorization.push_back(value);
    } else if (name == "x-api-key") {
      x_api_key.push_back(value);
    }
  }
  return PresentedKey(authorization, x_api_key);
}

}  // namespace cairn

#endif  // CAIRN_HTTP_KEYS_PRESENTED_KEY_H_
