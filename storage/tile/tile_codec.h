// Encodes and decodes tiles. The format is docs/formats/tile_v1.md.
#ifndef CAIRN_STORAGE_TILE_TILE_CODEC_H_
#define CAIRN_STORAGE_TILE_TILE_CODEC_H_

#include <cstddef>
#include <cstdint>
#include <set>
#include <span>
#include <vector>

#include "storage/tile/tile.h"
#include "storage/tile/tile_lists.h"

namespace cairn {

struct TileDecodeLimits {
  // A blob that claims more than these limits is refused before memory of that size is allocated.
  uint32_t max_landmarks = 4'000'000;
  uint32_t max_descriptors = 16'000'000;
  uint32_t max_keyframes = 200'000;
  uint64_t max_decoded_bytes = uint64_t{1} << 30;
};

// Deterministic: equal tiles and lists give equal bytes. Throws Error(kInternal) if the tile is
// inconsistent or the lists are not lists of its descriptors.
std::vector<uint8_t> EncodeTile(const Tile& tile, const TileLists& lists = {});

// Checks magic, version, lengths, checksum and every index before returning. Throws
// Error(kMapDamaged) with a description of the problem. Untrusted bytes cannot cause reads or
// writes out of bounds or allocations beyond the limits.
Tile DecodeTile(std::span<const uint8_t> blob, const TileDecodeLimits& limits = {});

// Also decodes the lists; `lists` becomes empty if the tile has none.
Tile DecodeTile(std::span<const uint8_t> blob, const TileDecodeLimits& limits, TileLists* lists);

// Returns the sessions that the tile names: those of its keyframes and of its landmarks' histories.
std::set<SessionId> SessionsInTile(const Tile& tile);
// Works like SessionsInTile without decoding the rest of the tile. Returns nothing for bytes that
// are no tile payload; throws as DecodeTile for a damaged one.
std::set<SessionId> SessionsInPayload(std::span<const uint8_t> blob);

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_TILE_CODEC_H_
