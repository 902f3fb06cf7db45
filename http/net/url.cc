#include "http/net/url.h"

#include <charconv>

namespace cairn {

std::optional<std::string> PercentDecode(std::string_view text, bool plus_is_space) {
  std::string decoded;
  decoded.reserve(text.size());
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '+' && plus_is_space) {
      decoded += ' ';
    } else if (text[i] != '%') {
      decoded += text[i];
    } else {
      uint8_t byte = 0;
      const std::string_view digits = text.substr(i + 1, 2);
      const auto [end, error] =
          std::from_chars(digits.data(), digits.data() + digits.size(), byte, 16);
      if (error != std::errc() || digits.size() != 2 || end != digits.data() + 2 || byte == 0) {
        return std::nullopt;
      }
      decoded += static_cast<char>(byte);
      i += 2;
    }
  }
  return decoded;
}

std::optional<Target> ParseTarget(std::string_view target) {
  const size_t question = target.find('?');
  const std::optional<std::string> path =
      PercentDecode(target.substr(0, question), /*plus_is_space=*/false);
  if (!path) {
    return std::nullopt;
  }
  Target parsed{.path = *path, .query = {}};
  std::string_view rest = question == std::string_view::npos ? "" : target.substr(question + 1);
  while (!rest.empty()) {
    const size_t ampersand = rest.find('&');
    const std::string_view pair = rest.substr(0, ampersand);
    rest = ampersand == std::string_view::npos ? "" : rest.substr(ampersand + 1);
    if (pair.empty()) {
      continue;
    }
    const size_t equals = pair.find('=');
    const auto key = PercentDecode(pair.substr(0, equals), /*plus_is_space=*/true);
    const auto value = PercentDecode(
        equals == std::string_view::npos ? "" : pair.substr(equals + 1), /*plus_is_space=*/true);
    if (!key || !value) {
      return std::nullopt;
    }
    parsed.query.emplace(*key, *value);
  }
  return parsed;
}

}  // namespace cairn
