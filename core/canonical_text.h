// Makes texts equal that look the same to people.
#ifndef CAIRN_CORE_CANONICAL_TEXT_H_
#define CAIRN_CORE_CANONICAL_TEXT_H_

#include <string>
#include <string_view>

namespace cairn {

// Returns the text with its characters canonically decomposed (Unicode's form NFD), which is how
// macOS writes names, and in lower case, as far as it is ASCII, Latin, Greek or Cyrillic. Two texts
// in the forms NFC and NFD of the same characters become equal. Bytes that are not UTF-8, and
// characters outside of the Basic Multilingual Plane, stay unchanged.
std::string CanonicalText(std::string_view text);

}  // namespace cairn

#endif  // CAIRN_CORE_CANONICAL_TEXT_H_
