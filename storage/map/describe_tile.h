// Builds the record that a map's index keeps of a tile.
#ifndef CAIRN_STORAGE_MAP_DESCRIBE_TILE_H_
#define CAIRN_STORAGE_MAP_DESCRIBE_TILE_H_

#include "storage/map/map_store.h"
#include "storage/tile/tile.h"

namespace cairn {

// Describes a tile that has at least one landmark and one keyframe. The store fills in the
// payload's id and size later.
TileRecord DescribeTile(const Tile& tile);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_DESCRIBE_TILE_H_
