#include "ingest/join_tiles.h"

#include <algorithm>
#include <optional>
#include <set>

#include "ingest/tile_upkeep.h"
#include "ingest/tiles/admit_landmarks.h"
#include "ingest/tiles/merge_tiles.h"
#include "ingest/tiles/place_budget.h"
#include "ingest/tiles/tile_edit.h"
#include "ingest/tiles/viewpoints.h"

namespace cairn {
namespace {

int64_t CountCommon(const Tile& known, const Tile& fresh) {
  const std::set<LandmarkId> ids(known.landmark_ids.begin(), known.landmark_ids.end());
  return std::count_if(fresh.landmark_ids.begin(), fresh.landmark_ids.end(),
                       [&](LandmarkId id) { return ids.contains(id); });
}

// The landmarks of `fresh` that the tile takes.
Tile Admit(const Tile& known, const Tile& fresh, int enough_landmarks, TileChanges* changes) {
  Tile admitted = PickLandmarks(fresh, AdmitLandmarks(known, fresh, enough_landmarks));
  changes->num_merged = CountCommon(known, admitted);
  changes->num_new = static_cast<int64_t>(admitted.num_landmarks()) - changes->num_merged;
  changes->num_not_needed = static_cast<int64_t>(fresh.num_landmarks() - admitted.num_landmarks());
  return admitted;
}

// The tile without landmarks that faded and keyframes that gave way.
Tile LetGo(const Tile& tile, const TileJoinContext& context, JoinedTile* joined) {
  const Tile existing = WithoutFaded(tile, *context.upkeep, *context.session_times);
  joined->changes.num_faded = static_cast<int64_t>(tile.num_landmarks() - existing.num_landmarks());
  joined->replaced_keyframes = ReplacedKeyframes(existing, context.upkeep->viewpoints);
  joined->changes.num_keyframes_replaced = std::ssize(joined->replaced_keyframes);
  return WithoutKeyframes(existing, joined->replaced_keyframes);
}

}  // namespace

JoinedTile JoinTiles(const Tile& known, const Tile& fresh,
                     const std::function<void(Tile*)>& note_chances,
                     const TileJoinContext& context) {
  const UpkeepOptions& upkeep = *context.upkeep;
  JoinedTile joined;
  TileChanges& changes = joined.changes;
  const Tile admitted = Admit(known, fresh, upkeep.enough_landmarks, &changes);
  Tile tile = MergeTiles(known, admitted, *context.codec, *context.summarizer, upkeep.merging);
  if (context.is_judged) {
    note_chances(&tile);
    tile = LetGo(tile, context, &joined);
  }
  joined.tile =
      SelectLandmarks(tile,
                      RateByHistory(tile, *context.session_times, upkeep.persistence,
                                    context.selection->min_observations),
                      context.is_judged ? BytesOfPlace(known, fresh, admitted) : std::nullopt,
                      *context.selection, *context.selector);
  changes.num_evicted = static_cast<int64_t>(tile.num_landmarks() - joined.tile.num_landmarks());
  return joined;
}

}  // namespace cairn
