// The input of an ingest, as an archive stores it.
#ifndef CAIRN_INGEST_MAPS_ARCHIVED_SESSION_H_
#define CAIRN_INGEST_MAPS_ARCHIVED_SESSION_H_

#include <string>
#include <vector>

#include "core/rigid3.h"
#include "core/scene/reconstruction.h"
#include "storage/map/map_store.h"

namespace cairn {

// A session of the map by name and content.
struct SessionKey {
  std::string name;
  std::string content_digest;  // As SessionRecord::content_digest.

  bool operator==(const SessionKey&) const = default;
};

// All of a session but its reconstruction.
struct ArchiveManifest {
  SessionKey session;
  std::string source;             // For people.
  std::string given_recorded_at;  // As the ingest was told; may be empty.
  std::string recorded_at;        // Of the session in the map.
  std::string options_json;       // The options of the ingest.
  std::string map_created_at;     // MapInfo::created_at of the map that got the session.
  FirstIds first_ids;             // Ids of the session in the map; 0 for unknown ones.
  bool is_apart = false;          // SessionJoining::kApart.
  double georef_median_residual_m = 0.0;
  Sim3d ecef_from_world;
  // Sessions of the map before this one, in the order of ingest.
  std::vector<SessionKey> earlier_sessions;
  // Of the reconstruction.
  std::string descriptor_type;
  int descriptor_dim = 0;
  size_t num_cameras = 0;
  size_t num_images = 0;
  size_t num_landmarks = 0;
};

struct ArchivedSession {
  ArchiveManifest manifest;
  Reconstruction reconstruction;  // Without positions of photos by GPS.
};

}  // namespace cairn

#endif  // CAIRN_INGEST_MAPS_ARCHIVED_SESSION_H_
