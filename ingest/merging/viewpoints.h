// What the keyframes of a new session say about the landmarks and keyframes of a tile: which
// landmarks they should have seen, and which older keyframes they replace.
#ifndef CAIRN_INGEST_MERGING_VIEWPOINTS_H_
#define CAIRN_INGEST_MERGING_VIEWPOINTS_H_

#include <map>
#include <vector>

#include "core/camera.h"
#include "storage/ids.h"
#include "storage/tile/tile.h"

namespace cairn {

// Keyframes closer than this, with optical axes closer than this, have the same viewpoint: they
// should see the same landmarks.
struct ViewpointOptions {
  double radius_m = 3.0;
  double angle_rad = 0.5;
};

// Counts, for each landmark of the tile, the keyframes of a session that should see it: a keyframe
// of the same viewpoint sees it, and it projects into the image. A landmark that no keyframe sees
// any more has a chance where it projects into the image, its direction to the camera is one of its
// descriptors', and it would be neither too small nor too large to be detected. `cameras` has the
// camera of each keyframe of the session.
std::vector<int> CountChances(const Tile& tile, SessionId session_id,
                              const std::map<KeyframeId, const Camera*>& cameras,
                              const ViewpointOptions& options);

// Writes the chances of a session into the histories of the landmarks. A landmark that the session
// missed gets a sighting without sights.
void NoteChances(const std::vector<int>& chances, SessionId session_id, Tile* tile);

// Returns the keyframes whose viewpoint two newer sessions share. The newest session shows what the
// place looks like now; the session before stays in case the newest is removed. A map therefore
// holds a bounded number of keyframes.
std::vector<KeyframeId> ReplacedKeyframes(const Tile& tile, const ViewpointOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_MERGING_VIEWPOINTS_H_
