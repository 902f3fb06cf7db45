// Decoded tile <-> compressed blob. The format is docs/formats/tile_v1.md.
#ifndef CAIRN_STORAGE_TILE_TILE_CODEC_H_
#define CAIRN_STORAGE_TILE_TILE_CODEC_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "storage/tile/tile.h"
#include "storage/tile/tile_lists.h"

namespace cairn {

struct TileDecodeLimits {
  // A blob that claims more is refused before anything of that size is allocated.
  uint32_t max_landmarks = 4'000'000;
  uint32_t max_descriptors = 16'000'000;
  uint32_t max_keyframes = 200'000;
  uint64_t max_decoded_bytes = uint64_t{1} << 30;
};

// Deterministic: equal tiles give equal bytes. Throws Error(kInternal) if the tile is inconsistent
// or the lists are not of its descriptors.
std::vector<uint8_t> EncodeTile(const Tile& tile, const TileLists& lists = {});

// Checks magic, version, lengths, checksum and every index before it returns. Throws
// Error(kMapDamaged) that says what is wrong; no input can make it read or write out of bounds or
// allocate more than the limits allow.
Tile DecodeTile(std::span<const uint8_t> blob, const TileDecodeLimits& limits = {});

// The same and its lists, if it has any.
Tile DecodeTile(std::span<const uint8_t> blob, const TileDecodeLimits& limits, TileLists* lists);

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_TILE_CODEC_H_
