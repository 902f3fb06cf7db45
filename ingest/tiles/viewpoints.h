// Finds the landmarks of a tile that a new session should have seen, and the older keyframes that
// its keyframes replace.
#ifndef CAIRN_INGEST_TILES_VIEWPOINTS_H_
#define CAIRN_INGEST_TILES_VIEWPOINTS_H_

#include <map>
#include <vector>

#include "core/camera.h"
#include "storage/ids.h"
#include "storage/tile/tile.h"

namespace cairn {

// Two keyframes within this radius, with optical axes within this angle, have the same viewpoint:
// they should see the same landmarks.
struct ViewpointOptions {
  double radius_m = 3.0;
  double angle_rad = 0.5;
};

// Counts, for each landmark of the tile, its chances: the keyframes of a session that should see
// the landmark. A keyframe should see a landmark that projects into its image and that a keyframe
// of the same viewpoint sees. If no keyframe sees the landmark any more, two other conditions stand
// in for the second one: a descriptor of the landmark was seen from this direction, and the
// landmark appears at a size that detectors find. `cameras` has the camera of each keyframe of the
// session.
std::vector<int> CountChances(const Tile& tile, SessionId session_id,
                              const std::map<KeyframeId, const Camera*>& cameras,
                              const ViewpointOptions& options);

// Writes the chances of a session into the histories of the landmarks. A landmark that the session
// missed gets an entry without observations.
void NoteChances(const std::vector<int>& chances, SessionId session_id, Tile* tile);

// Returns the keyframes whose viewpoint two newer sessions share. The newest session shows what the
// place looks like now. The session before stays in case the newest is removed; of its keyframes, a
// viewpoint keeps the last 16. The number of keyframes in a map, apart from those of the newest
// session, is therefore bounded.
std::vector<KeyframeId> ReplacedKeyframes(const Tile& tile, const ViewpointOptions& options);

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_VIEWPOINTS_H_
