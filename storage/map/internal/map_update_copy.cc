// The part of MapUpdate that copies content from another map.
#include <set>

#include "core/check.h"
#include "storage/map/internal/map_internal.h"
#include "storage/map/internal/map_queries.h"
#include "storage/tile/tile_codec.h"

namespace cairn {

void MapUpdate::CopyTiles(const MapSnapshot& from, const std::vector<TileRecord>& tiles) {
  CAIRN_CHECK(base_version() == MapVersion(1) && Sessions().empty(), "the map must be empty");
  if (const std::shared_ptr<const Codebook> codebook = from.CurrentCodebook()) {
    impl_->head.SetCurrentCodebook(impl_->head.StoreCodebook(*codebook, codebook->id));
  }
  ReserveLandmarkIds(Value(from.NextLandmarkId()) - 1);
  std::vector<KeyframeRecord> keyframes;
  std::set<CodebookId> codebook_ids;
  std::set<SessionId> session_ids;
  for (const TileRecord& tile : tiles) {
    if (codebook_ids.insert(tile.codebook_id).second) {
      impl_->head.StoreCodebook(*from.LoadCodebook(tile.codebook_id), tile.codebook_id);
    }
    const LargeVector<uint8_t> payload = from.LoadPayload(tile.payload_id);
    impl_->head.PutTile(tile, payload);
    session_ids.merge(SessionsInPayload(payload));
    for (KeyframeRecord& keyframe : from.KeyframesOfTile(tile.tile_id)) {
      session_ids.insert(keyframe.session_id);
      keyframes.push_back(std::move(keyframe));
    }
  }
  for (const SessionRecord& session : from.Sessions()) {
    if (session_ids.contains(session.id)) {
      impl_->head.InsertSession(session);
    }
  }
  for (const KeyframeRecord& keyframe : keyframes) {
    impl_->head.InsertKeyframe(keyframe);
  }
}

}  // namespace cairn
