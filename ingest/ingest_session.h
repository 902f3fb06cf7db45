// From a reconstruction to tiles in a map: the whole of `cairn ingest`.
#ifndef CAIRN_INGEST_INGEST_SESSION_H_
#define CAIRN_INGEST_INGEST_SESSION_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/rigid3.h"
#include "ingest/quantize/train_codebook.h"
#include "ingest/sfm/reconstruction.h"
#include "ingest/summarize/appearance.h"
#include "ingest/summarize/landmark_selection.h"
#include "storage/map/map_store.h"

namespace cairn {

struct IngestOptions {
  std::string session_name;  // Unique in the map; ingesting a name again replaces it.
  std::string source;        // For people.
  CodebookOptions codebook;  // Used only by the first session of a map.
  LandmarkSelectionOptions selection;
  AppearanceOptions appearance;
  // Landmarks with a larger position uncertainty are dropped, metres; and with a larger median
  // reprojection error, pixels.
  double max_sigma_m = 2.0;
  double max_reprojection_error_px = 4.0;
  double georef_median_residual_m = 0.0;  // Recorded with the session.

  void Validate() const;
};

// What the ingest did, for people and tests.
struct IngestReport {
  MapVersion map_version{};
  SessionId session_id{};
  bool replaced_session = false;
  int64_t num_images = 0;
  int64_t num_landmarks_read = 0;
  int64_t num_landmarks_dropped = 0;  // Uncertain or badly observed.
  int64_t num_tiles_written = 0;
  int64_t num_landmarks_written = 0;  // Sum over tiles.
  int64_t num_descriptors_written = 0;
  int64_t num_payload_bytes = 0;
};

// Phases "codebook", "tiles"; done of total.
using IngestProgress = std::function<void(const char* phase, int64_t done, int64_t total)>;

// Writes one session in one transaction: readers see all of it or nothing. Throws Error(kBadInput)
// if the descriptor type or dimension is not the map's, Error(kConflict) if another update runs.
// `ecef_from_world` places the reconstruction (see georegister.h).
IngestReport IngestSession(const Reconstruction& reconstruction, const Sim3d& ecef_from_world,
                           const IngestOptions& options, MapStore* store,
                           const IngestProgress& progress);

// Takes a session out of every tile and deletes it; tiles that are left empty go too. Throws
// Error(kNotFound).
MapVersion RemoveSession(const std::string& session_name, MapStore* store);

}  // namespace cairn

#endif  // CAIRN_INGEST_INGEST_SESSION_H_
