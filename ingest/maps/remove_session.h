// Takes a session out of a map: the whole of `cairn remove`.
#ifndef CAIRN_INGEST_MAPS_REMOVE_SESSION_H_
#define CAIRN_INGEST_MAPS_REMOVE_SESSION_H_

#include <cstdint>
#include <string>

#include "storage/map/map_store.h"

namespace cairn {

// The removal is exact for some content only. Keyframes of the session and landmarks that no other
// session has seen are removed without a trace. Landmarks that others have seen, too, lose the
// session's entry of the history; its share in their positions and descriptors cannot be told apart
// and stays. A tile in which only this session has keyframes left goes as a whole; an earlier
// version of the map still has it.
struct RemovalReport {
  MapVersion map_version{};
  int64_t num_landmarks_removed =
      0;  // A landmark counts once for each tile that holds it, as below.
  int64_t num_landmarks_shared = 0;  // Keep the session's share.
  int64_t num_tiles_rewritten = 0;
  int64_t num_tiles_removed = 0;
};

// Deletes a session from every tile; tiles that are left empty go, too. Throws Error(kNotFound).
RemovalReport RemoveSession(const std::string& session_name, MapStore* store);

}  // namespace cairn

#endif  // CAIRN_INGEST_MAPS_REMOVE_SESSION_H_
