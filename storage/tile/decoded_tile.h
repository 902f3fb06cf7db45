// What a payload holds: a tile and its lists.
#ifndef CAIRN_STORAGE_TILE_DECODED_TILE_H_
#define CAIRN_STORAGE_TILE_DECODED_TILE_H_

#include <cstddef>
#include <cstdint>
#include <span>

#include "storage/tile/tile.h"
#include "storage/tile/tile_codec.h"
#include "storage/tile/tile_lists.h"

namespace cairn {

// Encoding loses nothing: EncodeTile(tile, lists) makes a payload that decodes to the same members,
// bit by bit.
struct DecodedTile {
  Tile tile;
  TileLists lists;  // Empty if the tile has none.

  size_t MemoryBytes() const {
    return sizeof(*this) + tile.MemoryBytes() + lists.begin.capacity() * sizeof(uint32_t) +
           lists.members.size() * sizeof(uint32_t);
  }
};

// Throws as DecodeTile.
inline DecodedTile DecodePayload(std::span<const uint8_t> payload) {
  DecodedTile decoded;
  decoded.tile = DecodeTile(payload, {}, &decoded.lists);
  return decoded;
}

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_DECODED_TILE_H_
