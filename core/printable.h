// Text from outside, made fit for messages, logs and terminals.
#ifndef CAIRN_CORE_PRINTABLE_H_
#define CAIRN_CORE_PRINTABLE_H_

#include <cstddef>
#include <string>
#include <string_view>

namespace cairn {

// Most bytes of outside text that a message quotes.
inline constexpr size_t kMaxExcerptBytes = 100;

// The text with everything escaped that a terminal might obey or that hides what the text says:
// control characters (as \n, \t, \r or \x1b), C1 controls and marks of writing direction (as
// \u202e), bytes that are not UTF-8 (as \xff).
std::string Printable(std::string_view text);

// The same, but line feeds stay, for text that is made of lines.
std::string PrintableLines(std::string_view text);

// What a message quotes of a name, cell or value from outside: at most `max_bytes` of it, cut
// between characters, as Printable. If it is cut, the excerpt says how long the whole is:
// "aaaa... (2000000 bytes)".
std::string Excerpt(std::string_view text, size_t max_bytes = kMaxExcerptBytes);

}  // namespace cairn

#endif  // CAIRN_CORE_PRINTABLE_H_
