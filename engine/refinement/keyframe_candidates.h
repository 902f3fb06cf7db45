// Pose candidates from covisibility instead of votes, for queries without gravity.
#ifndef CAIRN_ENGINE_REFINEMENT_KEYFRAME_CANDIDATES_H_
#define CAIRN_ENGINE_REFINEMENT_KEYFRAME_CANDIDATES_H_

#include <vector>

#include "engine/query/pose_candidate.h"
#include "engine/query/query_context.h"
#include "engine/refinement/refinement_options.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

// Returns a candidate for each of the best ranked keyframes (see RankKeyframes). The candidate has
// the correspondences to landmarks that the keyframe or its neighborhood saw. Its score is the
// number of their distinct keypoints. Center and yaw stay zero, since P3P does not use them.
std::vector<PoseCandidate> KeyframeCandidates(const QueryContext& query,
                                              const std::vector<TileView>& tiles,
                                              const std::vector<Correspondence>& correspondences,
                                              const RefinementOptions& options);

}  // namespace cairn

#endif  // CAIRN_ENGINE_REFINEMENT_KEYFRAME_CANDIDATES_H_
