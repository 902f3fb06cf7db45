// The changes that an ingest plans: which tiles, from which content, under which ids.
#ifndef CAIRN_INGEST_SESSION_PLAN_H_
#define CAIRN_INGEST_SESSION_PLAN_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/tile_id.h"
#include "ingest/adjust_session.h"
#include "ingest/ingest_options.h"
#include "ingest/place/compare_with_map.h"
#include "ingest/tiles/landmark_history.h"
#include "storage/codebook/codebook.h"
#include "storage/map/map_store.h"

namespace cairn {

// Phases "codebook", "comparison", "links", "adjustment", "shards", "tiles", "answers",
// "publish"; done of total.
using IngestProgress = std::function<void(const char* phase, int64_t done, int64_t total)>;

// Calls `progress` unless it is empty.
inline void ReportProgress(const IngestProgress& progress, const char* phase, int64_t done,
                           int64_t total) {
  if (progress) {
    progress(phase, done, total);
  }
}

struct PlannedTile {
  TileId tile_id;
  std::string base_digest;  // Of the payload that the plan starts from; empty if there is none.
  KeyframeId first_keyframe{};
  int64_t num_keyframes = 0;
  int64_t work =
      0;  // Observations of the session plus landmarks of the map; time is about proportional.
};

// A value without the session's photos: all that publishing needs besides the built tiles.
struct SessionPlan {
  std::string map_created_at;  // MapInfo::created_at.
  MapVersion base_version{};
  SessionRecord session;         // With its reserved id.
  SessionId replaced_session{};  // 0: none.
  // The map holds exactly this session under this name already; there are no tiles.
  bool is_unchanged = false;

  std::shared_ptr<const Codebook> codebook;  // With its id in the map.
  bool adds_codebook = false;                // The map has none.
  IdCounts id_counts;                        // Number of ids reserved, of each kind.
  FirstIds first_ids;                        // First id of each kind.

  TileOptions options;
  GateOptions gate;
  SessionTimes session_times;      // Of all sessions of the map, and of this one.
  std::vector<PlannedTile> tiles;  // Ascending.

  // For the report.
  MapComparison comparison;
  JointAdjustment adjustment;
  int64_t num_landmarks_dropped = 0;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_SESSION_PLAN_H_
