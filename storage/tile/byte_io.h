// Little-endian writing and bounds-checked reading of byte strings. Private to
// storage, ingest and mapping.
#ifndef CAIRN_STORAGE_TILE_BYTE_IO_H_
#define CAIRN_STORAGE_TILE_BYTE_IO_H_

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "core/error.h"

namespace cairn {

static_assert(std::endian::native == std::endian::little,
              "numbers are copied as they are; a big-endian machine must swap their bytes here");

// Maps signed to unsigned values so that small magnitudes stay small: 0, -1, 1, -2 become 0, 1, 2,
// 3.
constexpr uint64_t ZigZag(uint64_t difference) {
  return (difference << 1) ^ (uint64_t{0} - (difference >> 63));
}
constexpr uint64_t UnZigZag(uint64_t code) { return (code >> 1) ^ (uint64_t{0} - (code & 1)); }

// Appends to a byte string.
class ByteWriter {
 public:
  explicit ByteWriter(std::vector<uint8_t>* out) : out_(out) {}

  template <typename T>
  void Put(T value) {
    PutArray(std::span<const T>(&value, 1));
  }

  template <typename T>
  void PutArray(std::span<const T> values) {
    static_assert(std::is_arithmetic_v<T>);
    const auto* bytes = reinterpret_cast<const uint8_t*>(values.data());
    out_->insert(out_->end(), bytes, bytes + values.size_bytes());
  }

  // Appends LEB128: seven bits a byte, lowest first; the top bit is set if more bytes follow.
  void PutVarint(uint32_t value) {
    for (; value >= 0x80; value >>= 7) {
      out_->push_back(static_cast<uint8_t>(value | 0x80));
    }
    out_->push_back(static_cast<uint8_t>(value));
  }

 private:
  std::vector<uint8_t>* out_;
};

// Reads untrusted bytes front to back. Every read past the end throws Error(kMapDamaged); the
// message begins with `what`.
class ByteReader {
 public:
  ByteReader(std::span<const uint8_t> bytes, std::string what)
      : bytes_(bytes), what_(std::move(what)) {}

  size_t remaining() const { return bytes_.size(); }

  std::span<const uint8_t> Take(size_t num_bytes) {
    if (num_bytes > bytes_.size()) {
      throw Error(ErrorCode::kMapDamaged, what_ + ": ends too early");
    }
    const std::span<const uint8_t> taken = bytes_.first(num_bytes);
    bytes_ = bytes_.subspan(num_bytes);
    return taken;
  }

  template <typename T>
  T Get() {
    T value;
    std::memcpy(&value, Take(sizeof(T)).data(), sizeof(T));
    return value;
  }

  template <typename T>
  void GetArray(std::span<T> values) {
    if (const std::span<const uint8_t> taken = Take(values.size_bytes()); !taken.empty()) {
      std::memcpy(values.data(), taken.data(), taken.size());
    }
  }

  template <typename T>
  std::vector<T> GetVector(size_t count) {
    CheckCount(count, sizeof(T));
    std::vector<T> values(count);
    GetArray(std::span<T>(values));
    return values;
  }

  // Reads byte planes: the lowest bytes of all values, then the second bytes of all values, and so
  // on.
  template <typename T>
  std::vector<T> GetPlanes(size_t count) {
    static_assert(std::is_unsigned_v<T>);
    CheckCount(count, sizeof(T));
    std::vector<T> values(count, 0);
    for (size_t shift = 0; shift < 8 * sizeof(T); shift += 8) {
      const uint8_t* plane = Take(count).data();
      for (size_t i = 0; i < count; ++i) {
        values[i] |= static_cast<T>(plane[i]) << shift;
      }
    }
    return values;
  }

  // The inverse of PutVarint. Accepts only the shortest form of a value.
  uint32_t GetVarint() {
    uint64_t value = 0;
    for (int shift = 0; shift < 35; shift += 7) {
      const uint8_t byte = Get<uint8_t>();
      value |= uint64_t{byte & 0x7fu} << shift;
      if ((byte & 0x80) == 0) {
        if (value > UINT32_MAX || (byte == 0 && shift > 0)) {
          break;
        }
        return static_cast<uint32_t>(value);
      }
    }
    throw Error(ErrorCode::kMapDamaged, what_ + ": malformed variable-length number");
  }

  // If each of the next eight bytes is a complete varint (below 128), consumes them and returns
  // them with the first byte lowest. Otherwise consumes nothing.
  std::optional<uint64_t> GetShortVarints() {
    constexpr uint64_t kMore = 0x8080808080808080;
    uint64_t bytes = kMore;
    if (bytes_.size() >= sizeof(bytes)) {
      std::memcpy(&bytes, bytes_.data(), sizeof(bytes));
    }
    if ((bytes & kMore) != 0) {
      return std::nullopt;
    }
    bytes_ = bytes_.subspan(sizeof(bytes));
    return bytes;
  }

 private:
  void CheckCount(size_t count, size_t size) const {
    if (count > bytes_.size() / size) {
      throw Error(ErrorCode::kMapDamaged, what_ + ": ends too early");
    }
  }

  std::span<const uint8_t> bytes_;
  std::string what_;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_BYTE_IO_H_
