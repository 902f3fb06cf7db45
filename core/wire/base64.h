// Base64 (RFC 4648 section 4): standard alphabet.
#ifndef CAIRN_CORE_WIRE_BASE64_H_
#define CAIRN_CORE_WIRE_BASE64_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cairn {

std::string EncodeBase64(std::span<const uint8_t> bytes);

// Returns nothing unless EncodeBase64 can produce exactly `text`: no line breaks, no missing
// padding, no stray bits in the last symbol.
std::optional<std::vector<uint8_t>> DecodeBase64(std::string_view text);

// Decodes what encoders of clients produce: text as above, also with blanks and line breaks (MIME,
// Android's default) and without padding.
std::optional<std::vector<uint8_t>> DecodeBase64OfClient(std::string_view text);

}  // namespace cairn

#endif  // CAIRN_CORE_WIRE_BASE64_H_
