// Tile ids of a small box, by arithmetic alone; private to storage.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_TILE_IDS_NEAR_H_
#define CAIRN_STORAGE_MAP_INTERNAL_TILE_IDS_NEAR_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "core/geodesy.h"

namespace cairn {

// Returns the ids of a block of squares of one UTM zone, in ascending order. The block has every
// tile whose bounding box meets `box`; a map need not have the others. Returns nothing if the box
// is wider than 8 km, near a pole, or near the border of a zone.
std::optional<std::vector<int64_t>> TileIdsNear(const GeoBox& box);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_INTERNAL_TILE_IDS_NEAR_H_
