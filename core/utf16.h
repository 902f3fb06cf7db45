// Recognizes text in UTF-16, which no reader of Cairn takes.
#ifndef CAIRN_CORE_UTF16_H_
#define CAIRN_CORE_UTF16_H_

#include <string_view>

namespace cairn {

// True if the text begins with the byte order mark of UTF-16, or with half of an ASCII letter.
inline bool IsUtf16(std::string_view text) {
  return text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff") ||
         (text.size() >= 2 && (text[0] == '\0') != (text[1] == '\0'));
}

}  // namespace cairn

#endif  // CAIRN_CORE_UTF16_H_
