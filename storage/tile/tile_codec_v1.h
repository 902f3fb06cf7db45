// Reads tile payloads of versions 1 and 2, docs/formats/tile_v1.md and tile_v2.md, which are no
// longer written; private to storage.
#ifndef CAIRN_STORAGE_TILE_TILE_CODEC_V1_H_
#define CAIRN_STORAGE_TILE_TILE_CODEC_V1_H_

#include <cstdint>
#include <span>

#include "storage/tile/tile.h"
#include "storage/tile/tile_codec.h"
#include "storage/tile/tile_lists.h"

namespace cairn {

// As DecodeTile.
Tile DecodeTileV1(std::span<const uint8_t> blob, const TileDecodeLimits& limits, TileLists* lists);

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_TILE_CODEC_V1_H_
