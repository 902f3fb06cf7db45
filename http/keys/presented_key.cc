#include "http/keys/presented_key.h"

#include <strings.h>

#include "core/wire/header_line.h"
#include "core/wire/problem.h"

namespace cairn {
namespace {

// Nothing if the scheme is another one.
std::optional<std::string_view> BearerKey(std::string_view value) {
  constexpr std::string_view kScheme = "bearer";
  value = TrimBlanks(value);
  const bool is_bearer = value.size() >= kScheme.size() &&
                         strncasecmp(value.data(), kScheme.data(), kScheme.size()) == 0;
  const std::string_view rest = is_bearer ? value.substr(kScheme.size()) : std::string_view();
  if (!is_bearer || (!rest.empty() && rest.front() != ' ')) {
    return std::nullopt;
  }
  return TrimBlanks(rest);
}

}  // namespace

std::optional<std::string> PresentedKey(const std::vector<std::string_view>& authorization,
                                        const std::vector<std::string_view>& x_api_key) {
  std::optional<std::string> presented;
  const auto take = [&presented](std::string_view key) {
    if (presented && *presented != key) {
      throw HttpError(ProblemCode::kUnauthorized, "the request has several API keys")
          .Header("WWW-Authenticate", "Bearer realm=\"cairn\", error=\"invalid_request\"");
    }
    presented = key;
  };
  for (const std::string_view value : authorization) {
    if (const std::optional<std::string_view> key = BearerKey(value)) {
      take(*key);
    }
  }
  for (const std::string_view value : x_api_key) {
    take(TrimBlanks(value));
  }
  return presented;
}

}  // namespace cairn
