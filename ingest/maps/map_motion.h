// A map that moves as a whole: its keyframes and landmarks change tiles. Private to ingest.
#ifndef CAIRN_INGEST_MAPS_MAP_MOTION_H_
#define CAIRN_INGEST_MAPS_MAP_MOTION_H_

#include <map>
#include <set>
#include <unordered_map>
#include <vector>

#include "core/rigid3.h"
#include "storage/map/map_store.h"
#include "storage/tile/tile.h"

namespace cairn {

// Immutable; safe to use from any thread.
class MapMotion {
 public:
  // Reads all keyframes of the map.
  MapMotion(const Sim3d& moved_from_ecef, const MapSnapshot& map);

  // The tiles in which keyframes stand after the motion, ascending.
  std::vector<TileId> TileIds() const;
  // The tiles in which these keyframes stood before. The tile of the same id comes first.
  std::vector<TileId> SourcesOf(TileId tile_id) const;

  void Move(KeyframeRecord* keyframe) const;
  // Returns the part of a stored tile that lies in `target` after the motion: keyframes, and the
  // landmarks that they see. Landmarks that no keyframe sees stay in their tile, or leave with its
  // first keyframe if no keyframe stays.
  Tile Part(const Tile& stored, TileId target) const;

 private:
  TileId TargetOf(KeyframeId keyframe_id, TileId stood_in) const;

  Sim3d moved_from_ecef_;
  std::unordered_map<KeyframeId, TileId> target_of_keyframe_;  // Of those that change their tile.
  std::map<TileId, std::set<TileId>> sources_of_tile_;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_MAPS_MAP_MOTION_H_
