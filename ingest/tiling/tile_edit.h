// Changes to decoded tiles: take landmarks, take out a session, join two; private to ingest.
#ifndef CAIRN_INGEST_TILING_TILE_EDIT_H_
#define CAIRN_INGEST_TILING_TILE_EDIT_H_

#include <cstdint>
#include <span>

#include "core/tile_id.h"
#include "storage/ids.h"
#include "storage/tile/tile.h"

namespace cairn {

// A tile without content.
Tile EmptyTile(TileId tile_id, CodebookId codebook_id, int code_size);

// The tile with just these landmarks (distinct indices), in this order, and all its keyframes.
Tile PickLandmarks(const Tile& tile, std::span<const uint32_t> landmarks);

// The tile without the landmarks and keyframes of a session.
Tile WithoutSession(const Tile& tile, SessionId session_id);

// Adds the content of `other`, which must be of the same tile and codebook.
void AppendTile(const Tile& other, Tile* tile);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILING_TILE_EDIT_H_
