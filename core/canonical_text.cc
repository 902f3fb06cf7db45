#include "core/canonical_text.h"

#include "core/decompositions.h"

namespace cairn {
namespace {

constexpr char32_t kFirstSyllable = 0xAC00, kLastSyllable = 0xD7A3;

void AppendUtf8(char32_t point, std::string* text) {
  const auto tail = [&](int shift) {
    text->push_back(static_cast<char>(0x80 | ((point >> shift) & 0x3F)));
  };
  if (point < 0x80) {
    text->push_back(static_cast<char>(point));
  } else if (point < 0x800) {
    text->push_back(static_cast<char>(0xC0 | (point >> 6)));
    tail(0);
  } else {
    text->push_back(static_cast<char>(0xE0 | (point >> 12)));
    tail(6);
    tail(0);
  }
}

// Simple case folding of Latin-1, Greek and Cyrillic letters without marks, and of ASCII.
char32_t LowerCase(char32_t point) {
  const auto within = [point](char32_t first, char32_t last) {
    return point >= first && point <= last;
  };
  if (within('A', 'Z') || (within(0xC0, 0xDE) && point != 0xD7) || within(0x391, 0x3A9) ||
      within(0x410, 0x42F)) {
    return point + 0x20;
  }
  return within(0x400, 0x40F) ? point + 0x50 : point;
}

void AppendSyllable(char32_t syllable, std::string* text) {
  constexpr char32_t kFirstL = 0x1100, kFirstV = 0x1161, kBeforeT = 0x11A7, kNumV = 21, kNumT = 28;
  const char32_t idx = syllable - kFirstSyllable;
  AppendUtf8(kFirstL + idx / (kNumV * kNumT), text);
  AppendUtf8(kFirstV + idx / kNumT % kNumV, text);
  if (idx % kNumT != 0) {
    AppendUtf8(kBeforeT + idx % kNumT, text);
  }
}

void AppendDecomposed(char32_t point, std::string* text) {
  if (point >= kFirstSyllable && point <= kLastSyllable) {
    AppendSyllable(point, text);
    return;
  }
  const Decomposition* const parts = FindDecomposition(point);
  if (parts == nullptr) {
    AppendUtf8(LowerCase(point), text);
    return;
  }
  AppendDecomposed(parts->first, text);
  if (parts->second != 0) {
    AppendDecomposed(parts->second, text);
  }
}

// Returns the code point of two or three bytes of UTF-8 at the front of `text`, and 0 for all other
// bytes: ASCII, code points outside of the Basic Multilingual Plane, and what is no UTF-8.
char32_t PointAt(std::string_view text) {
  const auto byte = [text](size_t i) { return static_cast<unsigned char>(text[i]); };
  const auto is_tail = [&](size_t i) { return i < text.size() && (byte(i) & 0xC0) == 0x80; };
  if ((byte(0) & 0xE0) == 0xC0 && is_tail(1)) {
    return char32_t(byte(0) & 0x1F) << 6 | (byte(1) & 0x3F);
  }
  if ((byte(0) & 0xF0) == 0xE0 && is_tail(1) && is_tail(2)) {
    return char32_t(byte(0) & 0x0F) << 12 | char32_t(byte(1) & 0x3F) << 6 | (byte(2) & 0x3F);
  }
  return 0;
}

}  // namespace

std::string CanonicalText(std::string_view text) {
  std::string canonical;
  canonical.reserve(text.size());
  while (!text.empty()) {
    const char32_t point = PointAt(text);
    if (point >= 0x80) {
      AppendDecomposed(point, &canonical);
      text.remove_prefix(point < 0x800 ? 2 : 3);
    } else {
      const char letter = text.front();
      canonical.push_back(letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter + 0x20)
                                                         : letter);
      text.remove_prefix(1);
    }
  }
  return canonical;
}

}  // namespace cairn
