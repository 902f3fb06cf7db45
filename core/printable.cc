#include "core/printable.h"

#include <fmt/format.h>

#include <cstdint>

namespace cairn {
namespace {

struct Character {
  uint32_t code = 0;
  size_t size = 1;          // Bytes.
  bool is_encoded = false;  // False if the first byte does not begin a valid UTF-8 sequence.
};

// Returns the first character of a non-empty text.
Character FirstCharacter(std::string_view text) {
  const auto byte = [text](size_t i) { return static_cast<uint8_t>(text[i]); };
  const uint8_t first = byte(0);
  if (first < 0x80) {
    return {first, 1, true};
  }
  const size_t size = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || text.size() < size) {
    return {first, 1, false};
  }
  uint32_t code = first & (0x7f >> size);
  for (size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0) != 0x80) {
      return {first, 1, false};
    }
    code = code << 6 | (byte(i) & 0x3f);
  }
  constexpr uint32_t kSmallest[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool is_surrogate = code >= 0xd800 && code <= 0xdfff;
  if (code < kSmallest[size] || code > 0x10ffff || is_surrogate) {
    return {first, 1, false};
  }
  return {code, size, true};
}

// Returns true for controls, line separators and marks of writing direction.
bool IsHarmful(uint32_t code) {
  return code < 0x20 || (code >= 0x7f && code < 0xa0) || code == 0x61c || code == 0x200e ||
         code == 0x200f || (code >= 0x2028 && code <= 0x202e) ||
         (code >= 0x2066 && code <= 0x2069) || code == 0xfeff;
}

std::string Escape(const Character& character) {
  switch (character.code) {
    case '\n':
      return "\\n";
    case '\r':
      return "\\r";
    case '\t':
      return "\\t";
    default:
      return character.is_encoded && character.code >= 0x80
                 ? fmt::format("\\u{:04x}", character.code)
                 : fmt::format("\\x{:02x}", character.code);
  }
}

std::string EscapeAllBut(std::string_view kept, std::string_view text) {
  std::string escaped;
  escaped.reserve(text.size());
  while (!text.empty()) {
    const Character character = FirstCharacter(text);
    const std::string_view bytes = text.substr(0, character.size);
    const bool is_plain = character.is_encoded && !IsHarmful(character.code);
    escaped += is_plain || kept.find(bytes) != std::string_view::npos ? std::string(bytes)
                                                                      : Escape(character);
    text.remove_prefix(character.size);
  }
  return escaped;
}

}  // namespace

std::string Printable(std::string_view text) { return EscapeAllBut("", text); }

std::string PrintableLines(std::string_view text) { return EscapeAllBut("\n", text); }

std::string Excerpt(std::string_view text, size_t max_bytes) {
  if (text.size() <= max_bytes) {
    return Printable(text);
  }
  size_t end = 0;
  while (true) {
    const size_t size = FirstCharacter(text.substr(end)).size;
    if (end + size > max_bytes) {
      break;
    }
    end += size;
  }
  return fmt::format("{}... ({} bytes)", Printable(text.substr(0, end)), text.size());
}

}  // namespace cairn
