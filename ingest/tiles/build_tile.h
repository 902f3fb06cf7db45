// The content that one session gives to one tile; private to ingest.
#ifndef CAIRN_INGEST_TILES_BUILD_TILE_H_
#define CAIRN_INGEST_TILES_BUILD_TILE_H_

#include <vector>

#include "core/scene/reconstruction.h"
#include "core/tile_id.h"
#include "ingest/tiles/appearance.h"
#include "ingest/tiles/placed_session.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/ids.h"
#include "storage/tile/tile.h"

namespace cairn {

// Input that all tiles of a session share. Refers to data of the caller.
struct TileSource {
  const Reconstruction* reconstruction = nullptr;
  const PlacedSession* session = nullptr;
  const DescriptorCodec* codec = nullptr;
  const AppearanceSummarizer* summarizer = nullptr;
  SessionId session_id{};
  std::vector<LandmarkId> landmark_ids;  // Parallel to session->landmarks; all different.
};

// The landmarks seen from the tile's images (PlacedSession::images_of_tile) with the appearances
// they have there, in no particular order. `keyframe_ids` is parallel to the images. A landmark's
// orientation, size and azimuth per mode are the circular, geometric and circular means over the
// mode's members. The history of a landmark is one entry, with as many chances as observations.
// Takes linear time in the observations, apart from one sort.
Tile BuildTile(const TileSource& source, TileId tile_id,
               const std::vector<KeyframeId>& keyframe_ids);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_BUILD_TILE_H_
