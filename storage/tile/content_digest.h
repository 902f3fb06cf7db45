// Names bytes by their content. Private to storage, ingest and mapping.
#ifndef CAIRN_STORAGE_TILE_CONTENT_DIGEST_H_
#define CAIRN_STORAGE_TILE_CONTENT_DIGEST_H_

#include <xxhash.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace cairn {

// The XXH3-128 hash with seed 0 of all bytes added so far.
class ContentHash {
 public:
  ContentHash() : state_(XXH3_createState(), &XXH3_freeState) { XXH3_128bits_reset(state_.get()); }

  void Add(std::span<const uint8_t> bytes) {
    XXH3_128bits_update(state_.get(), bytes.data(), bytes.size());
  }

  // Returns the hash, big-endian, as 32 lower-case hexadecimal digits.
  std::string Hex() const {
    constexpr char kDigits[] = "0123456789abcdef";
    XXH128_canonical_t canonical;
    XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state_.get()));
    std::string digest;
    for (const unsigned char byte : canonical.digest) {
      digest += kDigits[byte >> 4];
      digest += kDigits[byte & 15];
    }
    return digest;
  }

 private:
  std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state_;
};

inline std::string ContentDigest(std::span<const uint8_t> bytes) {
  ContentHash hash;
  hash.Add(bytes);
  return hash.Hex();
}

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_CONTENT_DIGEST_H_
