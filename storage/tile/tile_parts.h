// Shared by the writer and the reader of tile payloads. Private to storage.
#ifndef CAIRN_STORAGE_TILE_TILE_PARTS_H_
#define CAIRN_STORAGE_TILE_TILE_PARTS_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "core/error.h"
#include "core/tile_id.h"
#include "storage/tile/byte_io.h"

namespace cairn {

inline constexpr uint32_t kTileMagic = 0x4c495443;  // "CTIL".
inline constexpr size_t kTileHeaderSize = 72;
inline constexpr size_t kTileChecksumOffset = 64;
inline constexpr size_t kMaxVarintSize = 5;

[[noreturn]] inline void ThrowDamagedTile(const std::string& problem) {
  throw Error(ErrorCode::kMapDamaged, "tile payload: " + problem);
}

// Converts the id in a header; 0 means "no tile".
inline TileId TileIdFromPayload(uint64_t value) {
  try {
    return value == 0 ? TileId() : TileId::FromValue(value);
  } catch (const Error& error) {
    ThrowDamagedTile(error.what());
  }
}

// Reads `count` ascending indices below `end` and calls set(index) for each. The first varint is
// the first index; each following varint is a gap minus 1, since indices ascend.
template <typename Set>
void GetAscending(size_t count, uint32_t end, const char* problem, ByteReader* reader,
                  const Set& set) {
  // Most varints have one byte. kNumTogether such varints advance the index by at most kMaxAdvance.
  constexpr size_t kNumTogether = sizeof(uint64_t), kMaxAdvance = kNumTogether << 7;
  uint64_t next = 0;
  for (size_t i = 0; i < count;) {
    if (count - i >= kNumTogether && next + kMaxAdvance <= end) {
      if (const std::optional<uint64_t> bytes = reader->GetShortVarints()) {
        for (size_t j = 0; j < kNumTogether; ++j) {
          next += *bytes >> 8 * j & 0x7f;
          set(static_cast<uint32_t>(next));
          ++next;
        }
        i += kNumTogether;
        continue;
      }
    }
    next += reader->GetVarint();
    if (next >= end) {
      ThrowDamagedTile(problem);
    }
    set(static_cast<uint32_t>(next));
    ++next;
    ++i;
  }
}

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_TILE_PARTS_H_
