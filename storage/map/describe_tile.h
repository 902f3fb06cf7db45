// What the index of a map says about a tile.
#ifndef CAIRN_STORAGE_MAP_DESCRIBE_TILE_H_
#define CAIRN_STORAGE_MAP_DESCRIBE_TILE_H_

#include "storage/map/map_store.h"
#include "storage/tile/tile.h"

namespace cairn {

// The record of a tile that has at least one landmark and one keyframe. The payload's id and size
// are left to the store.
TileRecord DescribeTile(const Tile& tile);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_DESCRIBE_TILE_H_
