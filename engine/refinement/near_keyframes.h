// The mapping photos that show what a camera at a pose should see.
#ifndef CAIRN_ENGINE_REFINEMENT_NEAR_KEYFRAMES_H_
#define CAIRN_ENGINE_REFINEMENT_NEAR_KEYFRAMES_H_

#include <vector>

#include "core/rigid3.h"
#include "engine/matching/match_features.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

// Returns up to `max_count` keyframes, those nearest to the pose among all that look about the same
// way (within 60 degrees), nearest first. Takes linear time in the number of keyframes.
std::vector<KeyframeRef> NearKeyframes(const std::vector<TileView>& tiles,
                                       const Rigid3d& anchor_from_cam, int max_count);

}  // namespace cairn

#endif  // CAIRN_ENGINE_REFINEMENT_NEAR_KEYFRAMES_H_
