// Recognizes text in UTF-16, which no reader of Cairn takes.
#ifndef CAIRN_CORE_UTF16_H_
#define CAIRN_CORE_UTF16_H_

#include <cstddef>
#include <string_view>

namespace cairn {

// True if the text begins with the byte order mark of UTF-16, or with half of an ASCII letter, and
// none of its first units is zero, as in binary files.
inline bool IsUtf16(std::string_view text) {
  constexpr size_t kMaxSearchedBytes = 1000;
  for (size_t i = 0; i + 1 < text.size() && i < kMaxSearchedBytes; i += 2) {
    if (text[i] == '\0' && text[i + 1] == '\0') {
      return false;
    }
  }
  return text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff") ||
         (text.size() >= 2 && (text[0] == '\0') != (text[1] == '\0'));
}

}  // namespace cairn

#endif  // CAIRN_CORE_UTF16_H_
