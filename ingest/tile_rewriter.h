// Puts a session into one tile of the map, stage by stage. Private to ingest.
#ifndef CAIRN_INGEST_TILE_REWRITER_H_
#define CAIRN_INGEST_TILE_REWRITER_H_

#include <cstdint>
#include <map>
#include <optional>

#include "ingest/ingest_options.h"
#include "ingest/merging/landmark_history.h"
#include "ingest/summarize/landmark_selection.h"
#include "ingest/tiling/build_tile.h"
#include "storage/map/map_store.h"
#include "storage/tile/tile.h"

namespace cairn {

// What became of landmarks and keyframes. A landmark counts once for each tile that holds it.
struct TileChanges {
  int64_t num_merged = 0;      // Landmarks of the session that the map knew,
  int64_t num_new = 0;         // that it did not know,
  int64_t num_not_needed = 0;  // and that it did not take, as its photos see enough others.
  int64_t num_faded = 0;       // Known landmarks that went, since they probably exist no more.
  int64_t num_evicted = 0;     // Landmarks that the selection left out.
  int64_t num_keyframes_replaced = 0;
  int64_t num_bytes_before = 0;
  int64_t num_bytes_after = 0;

  void Add(const TileChanges& other);
};

// The tile of the map without a session (which may be none); nothing if the map has no such tile.
std::optional<Tile> LoadWithoutSession(TileId tile_id, SessionId without, const MapUpdate& update);

// What all tiles of an ingest share; nothing is owned.
struct TileRewriteContext {
  const IngestOptions* options = nullptr;
  const TileSource* source = nullptr;
  const LandmarkSelector* selector = nullptr;
  SessionId replaced_session{};  // 0: none.
  const SessionTimes* session_times = nullptr;
};

// Takes the replaced session out of the tile and puts the new one in:
// build - admit - merge - note chances - fade - replace keyframes - select - write. `written`
// receives the tile as the map holds it now. Throws Error(kConflict) if the tile has another
// codebook than the session, Error(kMapDamaged) if it does not decode.
TileChanges RewriteTile(const TileRewriteContext& context, TileId tile_id, MapUpdate* update,
                        Tile* written);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILE_REWRITER_H_
