// Finds how far a position is from the tiles of a map.
#ifndef CAIRN_ENGINE_NEAREST_TILE_H_
#define CAIRN_ENGINE_NEAREST_TILE_H_

#include <optional>

#include "core/geodesy.h"
#include "storage/map/map_store.h"

namespace cairn {

// Returns the distance on the ground from the position to the nearest tile's square; 0 inside of a
// tile, nothing if the map has no tiles. Looks at boxes of growing size, so that a tile in the
// direction of a corner may be up to a factor of 1.8 farther than another one. Throws as
// MapSnapshot's calls.
std::optional<double> NearestTileM(const MapSnapshot& map, const Geodetic& position);

}  // namespace cairn

#endif  // CAIRN_ENGINE_NEAREST_TILE_H_
