// Tiles as a map stores them; private to ingest.
#ifndef CAIRN_INGEST_TILES_WRITE_TILE_H_
#define CAIRN_INGEST_TILES_WRITE_TILE_H_

#include <cstdint>
#include <vector>

#include "storage/codebook/codebook.h"
#include "storage/map/map_store.h"
#include "storage/tile/tile.h"

namespace cairn {

// A tile as a map stores it. A tile without landmarks or without keyframes has no payload, and of
// its record only the tile id counts: the map does not hold it.
struct EncodedTile {
  TileRecord record;
  std::vector<uint8_t> payload;
};

// Puts the landmarks into Morton order and encodes the tile. Only a tile of `codebook`, the map's
// current codebook, gets inverted lists: queries cannot search other tiles. Deterministic.
EncodedTile EncodeForMap(const Tile& tile, const Codebook& codebook);

// Puts the tile into the map, or removes it from the map if it has no payload.
void PutTile(const EncodedTile& tile, MapUpdate* update);

// EncodeForMap and PutTile. Returns the bytes of the payload.
int64_t WriteTile(const Tile& tile, const Codebook& codebook, MapUpdate* update);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_WRITE_TILE_H_
