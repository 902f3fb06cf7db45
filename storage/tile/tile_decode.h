// Decodes the columns of a payload to a tile. Private to storage.
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

// Decodes the lists of a tile; empty if it has none. Throws Error(kMapDamaged).
TileLists DecodeLists(const TileColumns& columns);

// Decode parts of a tile. Throw Error(kMapDamaged).
LoadedLandmarks DecodeLandmarks(const TileColumns& columns);
LoadedCovisibility DecodeCovisibility(const TileColumns& columns);

// Returns num_descriptors x code_size bytes. `members` are the members of the tile's lists.
LargeVector<uint8_t> CodesInTileOrder(const TileColumns& columns,
                                      std::span<const uint32_t> members);

// Decodes the whole tile. `members` are the members of its lists. Throws Error(kMapDamaged).
Tile DecodeTileColumns(const TileColumns& columns, std::span<const uint32_t> members);

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_TILE_DECODE_H_
