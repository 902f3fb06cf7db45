// The report of an ingest, for people and tests.
#ifndef CAIRN_INGEST_INGEST_REPORT_H_
#define CAIRN_INGEST_INGEST_REPORT_H_

#include <cstdint>
#include <vector>

#include "ingest/adjust_session.h"
#include "ingest/place/ask_keyframes.h"
#include "ingest/place/compare_with_map.h"
#include "ingest/tile_changes.h"
#include "storage/ids.h"

namespace cairn {

// Where the codebook of an ingest came from.
enum class CodebookOrigin {
  kMap,      // The map had it before.
  kShipped,  // It came with Cairn; see ChooseCodebook.
  kTrained,  // It was trained on the session.
};

struct IngestReport {
  MapVersion map_version{};
  SessionId session_id{};
  bool replaced_session = false;
  // The map holds exactly this session under this name already; nothing was done.
  bool is_unchanged = false;
  CodebookOrigin codebook_origin = CodebookOrigin::kMap;
  MapComparison comparison;    // What the map said about the session; empty if it was kept apart.
  JointAdjustment adjustment;  // With the landmarks of the map; see SessionFitting::kAdjust.
  KeyframeAnswers keyframe_answers;  // Of keyframes that the map had before; see ask_keyframes.h.
  int64_t num_images = 0;
  int64_t num_landmarks_read = 0;
  int64_t num_landmarks_dropped = 0;  // Uncertain or badly observed.
  TileChanges changes;                // In all tiles of the session.
  int64_t num_tiles_written = 0;
  int64_t num_landmarks_written = 0;  // Sum over tiles.
  int64_t num_descriptors_written = 0;
  int64_t num_payload_bytes = 0;
  // The id of each landmark of the reconstruction in the map, 0 for dropped ones. An id below
  // `first_new_landmark` is of a landmark that the map knew. Empty if the plan was read from a
  // folder.
  std::vector<LandmarkId> landmark_ids;
  LandmarkId first_new_landmark{};
};

}  // namespace cairn

#endif  // CAIRN_INGEST_INGEST_REPORT_H_
