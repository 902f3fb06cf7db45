// A short hash that identifies contents, for entity tags. No protection against forgery.
#ifndef CAIRN_CORE_WIRE_FINGERPRINT_H_
#define CAIRN_CORE_WIRE_FINGERPRINT_H_

#include <bit>
#include <cstdint>
#include <string_view>

namespace cairn {

// FNV-1a, 64 bits.
class Fingerprint {
 public:
  void Add(uint64_t value) {
    for (int i = 0; i < 64; i += 8) {
      AddByte(static_cast<uint8_t>(value >> i));
    }
  }
  void Add(double value) { Add(std::bit_cast<uint64_t>(value)); }
  void Add(std::string_view text) {
    for (const char c : text) {
      AddByte(static_cast<uint8_t>(c));
    }
  }
  uint64_t value() const { return hash_; }

 private:
  void AddByte(uint8_t byte) { hash_ = (hash_ ^ byte) * uint64_t{0x100000001b3}; }

  uint64_t hash_ = 0xcbf29ce484222325;
};

}  // namespace cairn

#endif  // CAIRN_CORE_WIRE_FINGERPRINT_H_
