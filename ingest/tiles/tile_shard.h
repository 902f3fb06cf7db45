// The part of a session that one tile takes. Private to ingest.
#ifndef CAIRN_INGEST_TILES_TILE_SHARD_H_
#define CAIRN_INGEST_TILES_TILE_SHARD_H_

#include <cstdint>
#include <memory>
#include <vector>

#include "core/large_vector.h"
#include "core/scene/reconstruction.h"
#include "core/tile_id.h"
#include "ingest/tiles/placed_session.h"
#include "storage/ids.h"
#include "storage/tile/tile.h"

namespace cairn {

// All that the content of one tile depends on, besides what its tiles share: the part of a session
// that was seen from the tile, and the payload that the tile has in the map.
struct TileShard {
  TileId tile_id;
  LargeVector<uint8_t> base;  // The payload in the map; empty if the map has no such tile.
  // What `base` holds, without the session that is replaced, if it has been decoded; else null.
  std::shared_ptr<const Tile> known;

  // The images that stand in the tile, in the order of the session, with the keypoints that see
  // landmarks, and a camera an image. There are none if the tile only loses a session that is
  // replaced. World poses, landmarks and GPS positions of the reconstruction are left out.
  Reconstruction reconstruction;
  std::vector<KeyframeId> keyframe_ids;  // Parallel to the images.
  // The same images, and the landmarks that they see, in the order of the session. `recon_idx` is
  // 0.
  PlacedSession session;
  std::vector<LandmarkId> landmark_ids;  // Parallel to the landmarks.
};

// Cuts the images of a tile out of a session. They get consecutive ids from `first_keyframe` on.
// `base` stays empty. Takes linear time in the observations of the tile, apart from one sort.
TileShard CutShard(const Reconstruction& reconstruction, const PlacedSession& session,
                   const std::vector<LandmarkId>& landmark_ids, TileId tile_id,
                   KeyframeId first_keyframe);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_TILE_SHARD_H_
