// Changes to decoded tiles: take landmarks, take out a session, join two; private to ingest.
#ifndef CAIRN_INGEST_TILES_TILE_EDIT_H_
#define CAIRN_INGEST_TILES_TILE_EDIT_H_

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/tile_id.h"
#include "storage/ids.h"
#include "storage/tile/tile.h"

namespace cairn {

// A tile without content.
Tile EmptyTile(TileId tile_id, CodebookId codebook_id, int code_size);

// Adds a landmark of another tile of the same codebook: its position, history and descriptors, but
// no keyframe's observation of it.
void AppendLandmark(const Tile& source, uint32_t landmark_idx, Tile* target);

// The tile with just these landmarks (distinct indices), in this order, and all its keyframes.
Tile PickLandmarks(const Tile& tile, std::span<const uint32_t> landmarks);

// The tile with all its landmarks and those keyframes for which `keep` is true.
Tile PickKeyframes(const Tile& tile, const std::function<bool(const TileKeyframe&)>& keep);

// Gives each landmark another history.
void ReplaceHistories(const std::vector<std::vector<HistoryEntry>>& histories, Tile* tile);

// The tile without the keyframes of a session, without its history, and without the landmarks
// that no other session saw. Positions and descriptors of landmarks that others saw, too, stay as
// they are: a session's share in them cannot be told apart.
Tile WithoutSession(Tile tile, SessionId session_id);

// The tile with just these keyframes and the landmarks that they see, or, with `and_unseen`, those
// that no keyframe of the tile sees, too.
Tile CutKeyframes(const Tile& tile, const std::function<bool(const TileKeyframe&)>& keep,
                  bool and_unseen);

// Adds the content of `other`, which must be of the same tile and codebook.
void AppendTile(const Tile& other, Tile* tile);

// Adds the keyframes of `other`, which must be of the same tile and codebook, and those of its
// landmarks that the tile lacks. Landmarks of an id that the tile has stay as they are there.
void AppendMissing(const Tile& other, Tile* tile);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_TILE_EDIT_H_
