#include "http/keys/secret.h"

#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/rand.h>
#include <openssl/sha.h>

#include <algorithm>
#include <span>

#include "core/error.h"
#include "core/wire/base64.h"

namespace cairn {
namespace {

constexpr std::string_view kSecretPrefix = "cairn_";  // Scanners for leaked secrets look for it.

std::optional<uint8_t> HexDigit(char c) {
  if (c >= '0' && c <= '9') {
    return static_cast<uint8_t>(c - '0');
  }
  if (c >= 'a' && c <= 'f') {
    return static_cast<uint8_t>(c - 'a' + 10);
  }
  return std::nullopt;
}

}  // namespace

KeyHash RandomBits() {
  KeyHash bits;
  if (RAND_bytes(bits.data(), static_cast<int>(bits.size())) != 1) {
    throw Error(ErrorCode::kInternal, "the system has no random numbers");
  }
  return bits;
}

std::string NewSecret() {
  std::string text = EncodeBase64(RandomBits());
  text.erase(text.find_last_not_of('=') + 1);
  std::replace(text.begin(), text.end(), '+', '-');
  std::replace(text.begin(), text.end(), '/', '_');
  return std::string(kSecretPrefix) + text;
}

KeyHash HashOfSecret(std::string_view secret) {
  KeyHash hash;
  SHA256(reinterpret_cast<const unsigned char*>(secret.data()), secret.size(), hash.data());
  return hash;
}

KeyHash SaltedHash(const KeyHash& salt, const KeyHash& hash) {
  std::array<uint8_t, 2 * std::tuple_size_v<KeyHash>> both;
  std::copy(hash.begin(), hash.end(), std::copy(salt.begin(), salt.end(), both.begin()));
  KeyHash salted;
  SHA256(both.data(), both.size(), salted.data());
  return salted;
}

bool AreEqual(const KeyHash& a, const KeyHash& b) {
  return CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

std::string HexOf(const KeyHash& hash) {
  std::string hex;
  for (const uint8_t byte : hash) {
    hex += fmt::format("{:02x}", byte);
  }
  return hex;
}

std::optional<KeyHash> HashFromHex(std::string_view hex) {
  KeyHash hash;
  if (hex.size() != 2 * hash.size()) {
    return std::nullopt;
  }
  for (size_t i = 0; i < hash.size(); ++i) {
    const std::optional<uint8_t> high = HexDigit(hex[2 * i]);
    const std::optional<uint8_t> low = HexDigit(hex[2 * i + 1]);
    if (!high || !low) {
      return std::nullopt;
    }
    hash[i] = static_cast<uint8_t>(*high << 4 | *low);
  }
  return hash;
}

}  // namespace cairn
