#include "ingest/maps/map_motion.h"

#include <algorithm>
#include <cmath>

#include "core/geodesy.h"
#include "ingest/tiles/tile_edit.h"

namespace cairn {
namespace {

Sim3d operator*(const Sim3d& a_from_b, const Rigid3d& b_from_c) {
  return {a_from_b.scale, a_from_b.rotation * b_from_c.rotation, a_from_b * b_from_c.translation};
}

// Expresses the tile's content in the frame of another tile, moved.
void Reanchor(const Sim3d& target_from_tile, TileId target, Tile* tile) {
  for (Eigen::Vector3f& x_in_tile : tile->x_in_tile) {
    x_in_tile = QuantizePosition(target_from_tile * x_in_tile.cast<double>());
  }
  for (TileKeyframe& keyframe : tile->keyframes) {
    keyframe.cam_from_tile = CamFromTarget(keyframe.cam_from_tile, target_from_tile);
  }
  const Eigen::Vector3d east = target_from_tile.rotation * Eigen::Vector3d::UnitX();
  const double turn_rad = std::atan2(east.y(), east.x());
  for (uint8_t& code : tile->azimuth_codes) {
    code = AzimuthCode(AzimuthFromCode(code) + turn_rad);
  }
  tile->id = target;
}

}  // namespace

MapMotion::MapMotion(const Sim3d& moved_from_ecef, const MapSnapshot& map)
    : moved_from_ecef_(moved_from_ecef) {
  for (const SessionRecord& session : map.Sessions()) {
    for (KeyframeRecord keyframe : map.KeyframesOfSession(session.id)) {
      const TileId source = keyframe.tile_id;
      Move(&keyframe);
      if (keyframe.tile_id != source) {
        target_of_keyframe_.emplace(keyframe.id, keyframe.tile_id);
      }
      sources_of_tile_[keyframe.tile_id].insert(source);
    }
  }
}

std::vector<TileId> MapMotion::TileIds() const {
  std::vector<TileId> ids;
  for (const auto& [tile_id, sources] : sources_of_tile_) {
    ids.push_back(tile_id);
  }
  return ids;
}

std::vector<TileId> MapMotion::SourcesOf(TileId tile_id) const {
  const auto found = sources_of_tile_.find(tile_id);
  if (found == sources_of_tile_.end()) {
    return {};
  }
  std::vector<TileId> sources(found->second.begin(), found->second.end());
  std::stable_partition(sources.begin(), sources.end(),
                        [&](TileId source) { return source == tile_id; });
  return sources;
}

void MapMotion::Move(KeyframeRecord* keyframe) const {
  keyframe->cam_from_ecef = CamFromTarget(keyframe->cam_from_ecef, moved_from_ecef_);
  keyframe->tile_id =
      TileId::Containing(GeodeticFromEcef(keyframe->cam_from_ecef.Inverse().translation));
}

TileId MapMotion::TargetOf(KeyframeId keyframe_id, TileId stood_in) const {
  const auto found = target_of_keyframe_.find(keyframe_id);
  return found == target_of_keyframe_.end() ? stood_in : found->second;
}

Tile MapMotion::Part(const Tile& stored, TileId target) const {
  const auto is_in = [&](TileId tile_id) {
    return [this, &stored, tile_id](const TileKeyframe& keyframe) {
      return TargetOf(keyframe.id, stored.id) == tile_id;
    };
  };
  TileId home = stored.id;
  if (!stored.keyframes.empty() &&
      std::none_of(stored.keyframes.begin(), stored.keyframes.end(), is_in(home))) {
    home = TargetOf(stored.keyframes.front().id, home);
  }
  Tile part = CutKeyframes(stored, is_in(target), target == home);
  const Rigid3d target_from_ecef = EcefFromEnu(target.Anchor()).Inverse();
  Reanchor(target_from_ecef * moved_from_ecef_ * EcefFromEnu(stored.id.Anchor()), target, &part);
  return part;
}

}  // namespace cairn
