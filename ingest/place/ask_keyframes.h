// The gate before a publication: does the new version still know the photos of the map?
#ifndef CAIRN_INGEST_PLACE_ASK_KEYFRAMES_H_
#define CAIRN_INGEST_PLACE_ASK_KEYFRAMES_H_

#include <Eigen/Core>
#include <vector>

#include "core/rigid3.h"
#include "engine/tiles/map_tiles.h"
#include "ingest/place/tile_memory.h"
#include "storage/ids.h"
#include "storage/map/map_store.h"

namespace cairn {

// What became of the answers to keyframes of a map.
struct KeyframeAnswers {
  int num_asked = 0;
  int num_lost = 0;  // Right before, and wrong or missing now.

  void Add(const KeyframeAnswers& other) {
    num_asked += other.num_asked;
    num_lost += other.num_lost;
  }
};

// Returns keyframes of the map that stand within 60 m of one of `news_in_ecef`, the places of new
// photos, once `after_from_map` has moved them: evenly over all such keyframes, two for each tile
// that has some, but at least 12 and at most 200. Leaves out the session `without`, which may be
// none.
std::vector<KeyframeRecord> KeyframesNear(const MapSnapshot& map,
                                          const std::vector<Eigen::Vector3d>& news_in_ecef,
                                          const Sim3d& after_from_map, SessionId without);

// Localizes keyframes of the map `before` in the map `after`, by what `before` knows of their
// features (FeaturesOfKeyframe). Both maps have the same codebook, and share the memory of
// `before`. An answer is right within 1 m and 5 degrees of the keyframe's pose, moved by
// `after_from_before`. Keyframes without a right answer are asked for in `before`, too, and are not
// lost if they have none there. Takes one or two queries a keyframe. The result does not depend on
// `num_threads`.
KeyframeAnswers AskKeyframes(const std::vector<KeyframeRecord>& keyframes,
                             const RememberedTiles& before, const MapTiles& after,
                             const Sim3d& after_from_before, int num_threads);

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_ASK_KEYFRAMES_H_
