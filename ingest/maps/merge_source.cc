#include "ingest/maps/merge_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "core/error.h"
#include "ingest/tiles/tile_edit.h"

namespace cairn {
namespace {

constexpr int64_t kAllTiles = std::numeric_limits<int64_t>::max();

}  // namespace

std::string MergeSource::Describe() const {
  return fmt::format("{}, version {}", store_.ShortName(), Value(snapshot_.version()));
}

void MergeSource::RecodeTo(std::shared_ptr<const Codebook> codebook) {
  transcoder_.emplace(codebook_, std::move(codebook));
}

void MergeSource::Move(const Sim3d& moved_from_ecef) {
  motion_.emplace(moved_from_ecef, snapshot_);
}

std::vector<TileId> MergeSource::TileIds() const {
  std::set<TileId> stored;
  for (const TileRecord& tile : snapshot_.AllTiles(kAllTiles)) {
    stored.insert(tile.tile_id);
  }
  if (!motion_) {
    return {stored.begin(), stored.end()};
  }
  std::vector<TileId> ids = motion_->TileIds();
  std::erase_if(ids, [&](TileId tile_id) {
    const std::vector<TileId> sources = motion_->SourcesOf(tile_id);
    return std::none_of(sources.begin(), sources.end(),
                        [&](TileId source) { return stored.contains(source); });
  });
  return ids;
}

std::shared_ptr<const Tile> MergeSource::LoadTile(TileId tile_id) const {
  if (!motion_) {
    return LoadStored(tile_id);
  }
  std::optional<Tile> tile;
  for (const TileId source : motion_->SourcesOf(tile_id)) {
    const std::shared_ptr<const Tile> stored = LoadStored(source);
    if (stored == nullptr) {
      continue;
    }
    Tile part = motion_->Part(*stored, tile_id);
    if (tile) {
      AppendMissing(part, &*tile);
    } else {
      tile = std::move(part);
    }
  }
  return tile ? std::make_shared<const Tile>(*std::move(tile)) : nullptr;
}

std::shared_ptr<const Tile> MergeSource::LoadStored(TileId tile_id) const {
  const std::optional<TileRecord> record = snapshot_.FindTile(tile_id);
  if (!record) {
    return nullptr;
  }
  const auto recode = [&] {
    Tile tile = InOwnCodes(*record)->tile;
    transcoder_->Transcode(&tile);
    return DecodedTile{std::move(tile), {}};
  };
  const std::shared_ptr<const DecodedTile> decoded =
      transcoder_ ? tiles_.memory()->Made(record->digest + " recoded", recode)
                  : InOwnCodes(*record);
  return {decoded, &decoded->tile};
}

std::shared_ptr<const DecodedTile> MergeSource::InOwnCodes(const TileRecord& record) const {
  const std::shared_ptr<const DecodedTile> decoded = tiles_.Decoded(record);
  if (codebook_ == nullptr || decoded->tile.codebook_id != codebook_->id) {
    throw Error(ErrorCode::kMapDamaged,
                fmt::format("{}: tile {} is not coded with the map's codebook", path(),
                            record.tile_id.ToString()));
  }
  return decoded;
}

std::vector<KeyframeRecord> MergeSource::KeyframesOfTile(TileId tile_id) const {
  if (!motion_) {
    return snapshot_.KeyframesOfTile(tile_id);
  }
  std::vector<KeyframeRecord> keyframes;
  for (const TileId source : motion_->SourcesOf(tile_id)) {
    for (KeyframeRecord keyframe : snapshot_.KeyframesOfTile(source)) {
      motion_->Move(&keyframe);
      if (keyframe.tile_id == tile_id) {
        keyframes.push_back(std::move(keyframe));
      }
    }
  }
  return keyframes;
}

void MergeSource::CopySessions(CodebookId codebook_id, MapUpdate* update) {
  ids_.codebook_id = codebook_id;
  for (const SessionRecord& session : snapshot_.Sessions()) {
    const SessionId session_id = update->AddSession(session);
    ids_.sessions[session.id] = session_id;
    for (KeyframeRecord keyframe : snapshot_.KeyframesOfSession(session.id)) {
      keyframe.session_id = session_id;
      if (motion_) {
        motion_->Move(&keyframe);
      }
      ids_.keyframes[keyframe.id] = update->AddKeyframe(keyframe);
    }
  }
  const uint64_t num_landmarks = Value(snapshot_.NextLandmarkId()) - 1;
  ids_.landmark_offset = Value(update->ReserveLandmarkIds(num_landmarks)) - 1;
}

std::optional<Tile> MergeSource::LoadRenumbered(TileId tile_id, const MergeSource& other) const {
  const std::shared_ptr<const Tile> own = LoadTile(tile_id);
  if (own == nullptr) {
    return std::nullopt;
  }
  std::optional<Tile> tile = *own;
  const std::vector<LandmarkId>& own_ids = own->landmark_ids;
  RenumberTile(ids_, &*tile);
  for (size_t i = 0; i < own_ids.size(); ++i) {
    if (const auto link = links_.find(own_ids[i]); link != links_.end()) {
      tile->landmark_ids[i] = LandmarkId(Value(link->second) + other.ids_.landmark_offset);
    }
  }
  return tile;
}

}  // namespace cairn
