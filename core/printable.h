// Makes text from outside safe for messages, logs and terminals.
#ifndef CAIRN_CORE_PRINTABLE_H_
#define CAIRN_CORE_PRINTABLE_H_

#include <cstddef>
#include <string>
#include <string_view>

namespace cairn {

// A message quotes at most this many bytes of text from outside.
inline constexpr size_t kMaxExcerptBytes = 100;

// Escapes everything that a terminal might interpret or that disguises the text: control characters
// (as \n, \t, \r or \x1b), C1 controls and marks of writing direction (as \u202e), and bytes that
// are not UTF-8 (as \xff).
std::string Printable(std::string_view text);

// Like Printable, but keeps line feeds, for text that consists of lines.
std::string PrintableLines(std::string_view text);

// Quotes a name, cell or value from outside in a message: at most `max_bytes` of the text, cut
// between characters and escaped as Printable does. A shortened excerpt states the full length:
// "aaaa... (2000000 bytes)".
std::string Excerpt(std::string_view text, size_t max_bytes = kMaxExcerptBytes);

}  // namespace cairn

#endif  // CAIRN_CORE_PRINTABLE_H_
