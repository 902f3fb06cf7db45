// The secret that a client sends, and the hash of it that a server stores.
#ifndef CAIRN_HTTP_KEYS_SECRET_H_
#define CAIRN_HTTP_KEYS_SECRET_H_

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace cairn {

using KeyHash = std::array<uint8_t, 32>;

// Longer texts are no keys.
inline constexpr size_t kMaxSecretBytes = 256;

// Returns "cairn_" and 256 random bits in base64url: 49 characters that need no quotes anywhere.
// Throws Error(kInternal) if the system has no random numbers.
std::string NewSecret();

// Returns the SHA-256 of the text. A key has 256 random bits, so nobody can find it by trying; a
// slow hash, as passwords need it, would cost time for each request and add nothing.
KeyHash HashOfSecret(std::string_view secret);

// Returns the SHA-256 of the salt followed by the hash.
KeyHash SaltedHash(const KeyHash& salt, const KeyHash& hash);

// Returns 256 random bits; throws as NewSecret.
KeyHash RandomBits();

// Takes the same time for all hashes.
bool AreEqual(const KeyHash& a, const KeyHash& b);

// 64 hexadecimal digits in lower case.
std::string HexOf(const KeyHash& hash);
std::optional<KeyHash> HashFromHex(std::string_view hex);

}  // namespace cairn

#endif  // CAIRN_HTTP_KEYS_SECRET_H_
