// Encodes a tile and puts it into a map; private to ingest.
#ifndef CAIRN_INGEST_WRITE_TILE_H_
#define CAIRN_INGEST_WRITE_TILE_H_

#include <cstdint>

#include "storage/codebook/codebook.h"
#include "storage/map/map_store.h"
#include "storage/tile/tile.h"

namespace cairn {

// Puts the tile into the map with its landmarks in Morton order, or removes the tile from the map
// if it has no landmarks or no keyframes. Returns the bytes of its payload. Only a tile of
// `codebook`, the map's current codebook, gets inverted lists: queries cannot search other tiles.
int64_t WriteTile(const Tile& tile, const Codebook& codebook, MapUpdate* update);

}  // namespace cairn

#endif  // CAIRN_INGEST_WRITE_TILE_H_
