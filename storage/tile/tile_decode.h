// From the columns of a payload to a tile; private to storage.
#ifndef CAIRN_STORAGE_TILE_TILE_DECODE_H_
#define CAIRN_STORAGE_TILE_TILE_DECODE_H_

#include <cstdint>
#include <span>

#include "core/large_vector.h"
#include "storage/tile/tile.h"
#include "storage/tile/tile_columns.h"
#include "storage/tile/tile_lists.h"
#include "storage/tile/tile_payload.h"

namespace cairn {

// The lists of a tile, if it has any. Throws Error(kMapDamaged).
TileLists DecodeLists(const TileColumns& columns);

// Parts of a tile. Throw Error(kMapDamaged).
LoadedLandmarks DecodeLandmarks(const TileColumns& columns);
LoadedCovisibility DecodeCovisibility(const TileColumns& columns);

// num_descriptors x code_size; `members` are those of the tile's lists.
LargeVector<uint8_t> CodesInTileOrder(const TileColumns& columns,
                                      std::span<const uint32_t> members);

// All of a tile; `members` are those of its lists. Throws Error(kMapDamaged).
Tile DecodeTileColumns(const TileColumns& columns, std::span<const uint32_t> members);

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_TILE_DECODE_H_
