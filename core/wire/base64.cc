#include "core/wire/base64.h"

#include <algorithm>
#include <array>
#include <iterator>

namespace cairn {
namespace {

constexpr char kAlphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr uint8_t kInvalid = 0x80;  // A bit that no valid symbol value has.

constexpr std::array<uint8_t, 256> MakeValues() {
  std::array<uint8_t, 256> values{};
  values.fill(kInvalid);
  for (uint8_t i = 0; i < 64; ++i) {
    values[static_cast<uint8_t>(kAlphabet[i])] = i;
  }
  return values;
}
constexpr std::array<uint8_t, 256> kValues = MakeValues();

uint32_t ValueOf(char symbol) { return kValues[static_cast<uint8_t>(symbol)]; }

}  // namespace

std::string EncodeBase64(std::span<const uint8_t> bytes) {
  std::string text((bytes.size() + 2) / 3 * 4, '=');
  size_t out = 0;
  size_t i = 0;
  for (; i + 3 <= bytes.size(); i += 3) {
    const uint32_t group = bytes[i] << 16 | bytes[i + 1] << 8 | bytes[i + 2];
    for (int shift = 18; shift >= 0; shift -= 6) {
      text[out++] = kAlphabet[group >> shift & 63];
    }
  }
  const size_t rest = bytes.size() - i;
  if (rest > 0) {
    const uint32_t group = bytes[i] << 16 | (rest == 2 ? bytes[i + 1] << 8 : 0);
    text[out++] = kAlphabet[group >> 18 & 63];
    text[out++] = kAlphabet[group >> 12 & 63];
    if (rest == 2) {
      text[out++] = kAlphabet[group >> 6 & 63];
    }
  }
  return text;
}

std::optional<std::vector<uint8_t>> DecodeBase64(std::string_view text) {
  if (text.size() % 4 != 0) {
    return std::nullopt;
  }
  if (text.empty()) {
    return std::vector<uint8_t>();
  }
  const size_t padding = text.ends_with("==") ? 2 : text.ends_with('=') ? 1 : 0;
  const size_t num_groups = text.size() / 4 - (padding > 0 ? 1 : 0);
  std::vector<uint8_t> bytes(text.size() / 4 * 3 - padding);
  uint32_t seen =
      0;  // Collects kInvalid bits; a single test after the loop keeps the loop free of branches.
  size_t out = 0;
  for (size_t g = 0; g < num_groups; ++g) {
    const char* in = text.data() + 4 * g;
    const uint32_t a = ValueOf(in[0]), b = ValueOf(in[1]), c = ValueOf(in[2]), d = ValueOf(in[3]);
    seen |= a | b | c | d;
    bytes[out++] = static_cast<uint8_t>(a << 2 | b >> 4);
    bytes[out++] = static_cast<uint8_t>(b << 4 | c >> 2);
    bytes[out++] = static_cast<uint8_t>(c << 6 | d);
  }
  if (padding > 0) {
    const char* in = text.data() + 4 * num_groups;
    const uint32_t a = ValueOf(in[0]), b = ValueOf(in[1]);
    const uint32_t c = padding == 1 ? ValueOf(in[2]) : 0;
    const uint32_t stray = padding == 1 ? c & 3 : b & 15;
    if (stray != 0) {
      return std::nullopt;
    }
    seen |= a | b | c;
    bytes[out++] = static_cast<uint8_t>(a << 2 | b >> 4);
    if (padding == 1) {
      bytes[out++] = static_cast<uint8_t>(b << 4 | c >> 2);
    }
  }
  if ((seen & kInvalid) != 0) {
    return std::nullopt;
  }
  return bytes;
}

std::optional<std::vector<uint8_t>> DecodeBase64OfClient(std::string_view text) {
  if (auto bytes = DecodeBase64(text)) {
    return bytes;  // Most texts need no copy.
  }
  std::string canonical;
  canonical.reserve(text.size() + 2);
  std::copy_if(text.begin(), text.end(), std::back_inserter(canonical),
               [](char c) { return c != '\r' && c != '\n' && c != ' ' && c != '\t'; });
  if (!canonical.ends_with('=')) {
    canonical.append((4 - canonical.size() % 4) % 4, '=');
  }
  return DecodeBase64(canonical);
}

}  // namespace cairn
