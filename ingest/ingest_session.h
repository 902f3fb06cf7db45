// From a reconstruction to tiles in a map: the whole of `cairn ingest`.
#ifndef CAIRN_INGEST_INGEST_SESSION_H_
#define CAIRN_INGEST_INGEST_SESSION_H_

#include <cstdint>
#include <functional>
#include <vector>

#include "core/rigid3.h"
#include "ingest/ingest_options.h"
#include "ingest/sfm/reconstruction.h"
#include "ingest/tile_rewriter.h"
#include "storage/map/map_store.h"

namespace cairn {

// What the ingest did, for people and tests.
struct IngestReport {
  MapVersion map_version{};
  SessionId session_id{};
  bool replaced_session = false;
  // The map holds exactly this session under this name already; nothing was done.
  bool is_unchanged = false;
  MapComparison comparison;  // What the map said about the session; empty if it was kept apart.
  int64_t num_images = 0;
  int64_t num_landmarks_read = 0;
  int64_t num_landmarks_dropped = 0;  // Uncertain or badly observed.
  TileChanges changes;                // In all tiles of the session.
  int64_t num_tiles_written = 0;
  int64_t num_landmarks_written = 0;  // Sum over tiles.
  int64_t num_descriptors_written = 0;
  int64_t num_payload_bytes = 0;
  // The id of each landmark of the reconstruction in the map, 0 for dropped ones. An id below
  // `first_new_landmark` is of a landmark that the map knew.
  std::vector<LandmarkId> landmark_ids;
  LandmarkId first_new_landmark{};
};

// Phases "codebook", "comparison", "links", "tiles"; done of total.
using IngestProgress = std::function<void(const char* phase, int64_t done, int64_t total)>;

// Writes one session in one transaction: readers see all of it or nothing. `ecef_from_world` places
// the reconstruction (see georegister.h). With SessionJoining::kJoin the session is moved to where
// the map sees it, sights of landmarks that the map knows update these, and what earlier sessions
// saw and this one should have seen and did not fades. The same session again changes nothing.
//
// Throws Error(kBadInput) if the descriptor type or dimension is not the map's; Error(kConflict) if
// another update runs, or, with SessionJoining::kJoin, if the session contradicts the map or the
// map has the same reconstruction under another name.
IngestReport IngestSession(const Reconstruction& reconstruction, const Sim3d& ecef_from_world,
                           const IngestOptions& options, MapStore* store,
                           const IngestProgress& progress);

}  // namespace cairn

#endif  // CAIRN_INGEST_INGEST_SESSION_H_
