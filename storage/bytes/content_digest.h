// Names bytes by their content; private to storage.
#ifndef CAIRN_STORAGE_BYTES_CONTENT_DIGEST_H_
#define CAIRN_STORAGE_BYTES_CONTENT_DIGEST_H_

#include <xxhash.h>

#include <cstdint>
#include <span>
#include <string>

namespace cairn {

// Returns the XXH3-128 hash with seed 0, big-endian, as 32 lower-case hexadecimal digits.
inline std::string ContentDigest(std::span<const uint8_t> bytes) {
  constexpr char kDigits[] = "0123456789abcdef";
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits(bytes.data(), bytes.size()));
  std::string digest;
  for (const unsigned char byte : canonical.digest) {
    digest += kDigits[byte >> 4];
    digest += kDigits[byte & 15];
  }
  return digest;
}

}  // namespace cairn

#endif  // CAIRN_STORAGE_BYTES_CONTENT_DIGEST_H_
