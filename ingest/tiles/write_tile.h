// Tiles as a map stores them; private to ingest.
#ifndef CAIRN_INGEST_TILES_WRITE_TILE_H_
#define CAIRN_INGEST_TILES_WRITE_TILE_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "storage/codebook/codebook.h"
#include "storage/map/map_store.h"
#include "storage/tile/decoded_tile.h"
#include "storage/tile/tile.h"

namespace cairn {

// Returns whether a tile lacks landmarks or keyframes. Maps do not hold such tiles.
bool IsEmpty(const Tile& tile);

// A tile as a map stores it. An empty tile has no payload, and of its record only the tile id
// counts.
struct EncodedTile {
  TileRecord record;
  std::vector<uint8_t> payload;
  // What the payload decodes to; null if there is no payload, or if it was read from a file.
  std::shared_ptr<const DecodedTile> decoded;
};

// Puts the landmarks into Morton order. Only a tile of `codebook`, the map's current codebook, gets
// inverted lists: queries cannot search other tiles. Deterministic.
DecodedTile ReadyForMap(const Tile& tile, const Codebook& codebook);

// Encodes what ReadyForMap returns.
EncodedTile EncodeForMap(const Tile& tile, const Codebook& codebook);

// Puts the tile into the map, or removes it from the map if it has no payload.
void PutTile(const EncodedTile& tile, MapUpdate* update);

// EncodeForMap and PutTile. Returns the bytes of the payload.
int64_t WriteTile(const Tile& tile, const Codebook& codebook, MapUpdate* update);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_WRITE_TILE_H_
