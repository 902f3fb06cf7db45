// Joins the tile of a session, or of another map, with that of the map. Private to ingest.
#ifndef CAIRN_INGEST_JOIN_TILES_H_
#define CAIRN_INGEST_JOIN_TILES_H_

#include <functional>
#include <vector>

#include "ingest/ingest_options.h"
#include "ingest/tile_changes.h"
#include "ingest/tiles/appearance.h"
#include "ingest/tiles/landmark_history.h"
#include "ingest/tiles/landmark_selection.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/tile/tile.h"

namespace cairn {

// Input that all tiles of an ingest or a merge share. Refers to data of the caller.
struct TileJoinContext {
  const UpkeepOptions* upkeep = nullptr;
  const LandmarkSelectionOptions* selection = nullptr;
  const DescriptorCodec* codec = nullptr;
  const AppearanceSummarizer* summarizer = nullptr;
  const LandmarkSelector* selector = nullptr;  // Of `selection`.
  const SessionTimes* session_times = nullptr;
  // The placement of the fresh tile is known to fit that of the known one (IsJudged).
  bool is_judged = true;
};

struct JoinedTile {
  Tile tile;
  std::vector<KeyframeId> replaced_keyframes;  // The map drops them.
  TileChanges changes;                         // Without bytes.
};

// Makes the tile of an ingest or a merge:
// admit - merge - note chances - fade - replace keyframes - select.
// If the placement is not judged, nothing fades or gives way: the middle three steps are left out,
// and only the budget of the tile counts, not the size of the place.
// Both tiles have the ids of one map, in which the sessions of `fresh` are newer, and equal
// landmarks have equal ids. `note_chances` writes into the merged tile which landmarks the sessions
// of `fresh` should have seen; see NoteChances.
JoinedTile JoinTiles(const Tile& known, const Tile& fresh,
                     const std::function<void(Tile*)>& note_chances,
                     const TileJoinContext& context);

}  // namespace cairn

#endif  // CAIRN_INGEST_JOIN_TILES_H_
