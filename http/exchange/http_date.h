// The dates of HTTP headers.
#ifndef CAIRN_HTTP_EXCHANGE_HTTP_DATE_H_
#define CAIRN_HTTP_EXCHANGE_HTTP_DATE_H_

#include <chrono>
#include <optional>
#include <string>

namespace cairn {

// Reads "Sun, 06 Nov 1994 08:49:37 GMT", the one form that servers may write (RFC 9110 section
// 5.6.7). Returns nothing for other text.
std::optional<std::chrono::sys_seconds> ParseHttpDate(const std::string& text);

}  // namespace cairn

#endif  // CAIRN_HTTP_EXCHANGE_HTTP_DATE_H_
