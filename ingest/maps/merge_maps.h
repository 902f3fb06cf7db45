// Two maps in one.
#ifndef CAIRN_INGEST_MAPS_MERGE_MAPS_H_
#define CAIRN_INGEST_MAPS_MERGE_MAPS_H_

#include <cstdint>
#include <functional>
#include <string>

#include "ingest/ingest_options.h"
#include "ingest/place/ask_keyframes.h"
#include "ingest/place/compare_with_map.h"
#include "ingest/tile_changes.h"
#include "storage/map/map_store.h"

namespace cairn {

struct MapMergeOptions {
  // kJoin: map b meets map a as its sessions would in an ingest. kApart: landmarks of both stand
  // side by side in the tiles that both have, without a budget.
  SessionJoining joining = SessionJoining::kJoin;
  bool recode = false;  // Maps of different codebooks: b takes the codebook of a; see Transcoder.
  LandmarkSelectionOptions selection;
  AppearanceOptions appearance;
  AgreementOptions agreement;
  GateOptions gate;
  UpkeepOptions upkeep;
  int num_threads = 1;  // That ask the maps. The result does not depend on it.

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

struct MergeReport {
  int64_t num_tiles_of_both = 0;     // Tiles that hold landmarks of both maps.
  MapComparison comparison;          // What a says about b; empty if they were kept apart.
  TileChanges changes;               // In the tiles of both, unless they were kept apart.
  KeyframeAnswers keyframe_answers;  // Of keyframes of each map near photos of the other.
  MapTotals totals;                  // Of the merged map.
};

// Creates the map `to` with the latest versions of both maps. Sessions, keyframes and landmarks get
// new ids; the sessions of b are newer than those of a. The past versions stay behind.
//
// With kJoin, the engine localizes keyframes of b in a, b moves as a whole to where a sees it,
// landmarks that both have become one, and the tiles of both get the upkeep of an ingest. The maps
// have no photos: queries and links use projected landmarks and decoded descriptors.
//
// `progress` may be empty; it receives the number of tiles done and the total. Throws
// Error(kConflict) with the reason if the codebooks differ (unless b is recoded), if b contradicts
// a, if both maps have a session of the same name or of the same content, if `to` exists, or if the
// merged map no longer localizes keyframes of a or b (RequireAnswers; those of b are not asked for
// if b is recoded, and those of maps that are kept apart are only counted). A map b that a cannot
// judge takes nothing from a. Throws Error(kBadInput) if the descriptors are of different types.
MergeReport MergeMaps(const MapStore& a, const MapStore& b, const std::string& to,
                      const MapMergeOptions& options,
                      const std::function<void(int64_t, int64_t)>& progress);

}  // namespace cairn

#endif  // CAIRN_INGEST_MAPS_MERGE_MAPS_H_
