// One line of the head of an HTTP message.
#ifndef CAIRN_CORE_WIRE_HEADER_LINE_H_
#define CAIRN_CORE_WIRE_HEADER_LINE_H_

#include <optional>
#include <string>
#include <string_view>

namespace cairn {

struct HeaderLine {
  std::string name;        // In lower case; a token (RFC 9110 section 5.6.2).
  std::string_view value;  // A part of the line, without blanks around it.
};

// Splits "Name: value", without its CRLF. Returns nothing for other lines: the name is empty or no
// token, as with a blank before the colon and in folded lines, or a control character other than
// tab is in the value.
std::optional<HeaderLine> SplitHeaderLine(std::string_view line);

// Returns true if `text` is a token, as names of headers and methods are.
bool IsToken(std::string_view text);

// Returns true if `text` has no control character but tabs.
bool IsHeaderText(std::string_view text);

// Removes blanks and tabs at both ends.
std::string_view TrimBlanks(std::string_view text);

// Changes A to Z only.
std::string ToLowerAscii(std::string_view text);

}  // namespace cairn

#endif  // CAIRN_CORE_WIRE_HEADER_LINE_H_
