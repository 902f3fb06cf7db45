#include "ingest/tiles/renumber_tile.h"

#include "core/error.h"

namespace cairn {
namespace {

template <typename Id>
Id NewId(const std::unordered_map<Id, Id>& ids, Id old_id, const Tile& tile) {
  const auto found = ids.find(old_id);
  if (found == ids.end()) {
    throw Error(ErrorCode::kMapDamaged,
                "tile " + tile.id.ToString() + ": has a session or keyframe that its map lacks");
  }
  return found->second;
}

}  // namespace

void RenumberTile(const NewIds& ids, Tile* tile) {
  tile->codebook_id = ids.codebook_id;
  for (LandmarkId& id : tile->landmark_ids) {
    id = LandmarkId(Value(id) + ids.landmark_offset);
  }
  for (HistoryEntry& entry : tile->history) {
    if (entry.session_id != SessionId{}) {
      entry.session_id = NewId(ids.sessions, entry.session_id, *tile);
    }
  }
  for (TileKeyframe& keyframe : tile->keyframes) {
    keyframe.id = NewId(ids.keyframes, keyframe.id, *tile);
    keyframe.session_id = NewId(ids.sessions, keyframe.session_id, *tile);
  }
}

}  // namespace cairn
