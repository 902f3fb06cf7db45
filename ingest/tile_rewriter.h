// Puts a session into one tile, stage by stage: a function of the payload that the map has and of
// the observations of the session. Private to ingest.
#ifndef CAIRN_INGEST_TILE_REWRITER_H_
#define CAIRN_INGEST_TILE_REWRITER_H_

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "ingest/ingest_options.h"
#include "ingest/tile_changes.h"
#include "ingest/tiles/build_tile.h"
#include "ingest/tiles/landmark_history.h"
#include "ingest/tiles/landmark_selection.h"
#include "ingest/tiles/tile_shard.h"
#include "ingest/tiles/write_tile.h"
#include "storage/map/map_store.h"
#include "storage/tile/tile.h"

namespace cairn {

// Input that all tiles of an ingest share. Refers to data of the caller.
struct TileRewriteContext {
  const TileOptions* options = nullptr;
  const TileSource* source = nullptr;
  const LandmarkSelector* selector = nullptr;
  SessionId replaced_session{};  // 0: none.
  const SessionTimes* session_times = nullptr;
  bool is_judged = true;  // See TileJoinContext.
};

// The outcome for one tile. The caller writes it to the map.
struct RewrittenTile {
  EncodedTile encoded;
  std::vector<KeyframeId> replaced_keyframes;  // Of earlier sessions; the map drops them.
  TileChanges changes;
};

// Takes the replaced session out of the tile and puts the new one in:
// build - join - encode; see JoinTiles. A session that is kept apart stands beside the others. The
// selection rates the landmarks of a first session by their observations over the whole
// reconstruction. `shard` is the part of the session that the tile takes, with the payload that
// the map has. Depends on the
// arguments only, so tiles can be rewritten in any order, on any thread or machine. Throws
// Error(kConflict) if the tile has another codebook than the session, Error(kMapDamaged) if it does
// not decode.
RewrittenTile RewriteTile(const TileRewriteContext& context, const TileShard& shard);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILE_REWRITER_H_
