// Moves a tile's content into the ids of another map; private to ingest.
#ifndef CAIRN_INGEST_TILES_RENUMBER_TILE_H_
#define CAIRN_INGEST_TILES_RENUMBER_TILE_H_

#include <cstdint>
#include <unordered_map>

#include "storage/ids.h"
#include "storage/tile/tile.h"

namespace cairn {

// The ids of the new map for the ids of the old map.
struct NewIds {
  CodebookId codebook_id{};
  std::unordered_map<SessionId, SessionId> sessions;  // In the same order as the old ids.
  std::unordered_map<KeyframeId, KeyframeId> keyframes;
  uint64_t landmark_offset = 0;  // The new landmark id minus the old landmark id.
};

// Replaces every id in the tile. Throws Error(kMapDamaged) if the tile has a session or a keyframe
// for which there is no new id.
void RenumberTile(const NewIds& ids, Tile* tile);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_RENUMBER_TILE_H_
