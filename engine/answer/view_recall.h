// How much of what a query should see at its pose it does see.
#ifndef CAIRN_ENGINE_ANSWER_VIEW_RECALL_H_
#define CAIRN_ENGINE_ANSWER_VIEW_RECALL_H_

#include <vector>

#include "core/camera.h"
#include "engine/pose/pose_hypotheses.h"
#include "engine/query/query_context.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

// Returns the share of the landmarks in view that likely inliers of the pose show, (0, 1].
//
// The landmarks in view are those of the mapping photos nearest to the pose that look about the
// same way. Each counts by how well its descriptor is expected to match: features change with the
// distance and the direction from which they are seen. A query with few keypoints is expected to
// show few landmarks. A right pose shows a tenth of them or more. A wrong pose on a facade that
// repeats shows one or two in a hundred, because only the details that repeat match. So a map that
// lacks the true place, and therefore a better pose, can be recognized. Returns 1 if no landmark is
// expected. `camera` is the query's own camera under the pose.
//
// Takes time linear in the number of keyframes of the tiles, plus the landmarks of a few keyframes.
double ViewRecall(const QueryContext& query, const std::vector<TileView>& tiles,
                  const Camera& camera, const PoseHypothesis& hypothesis);

// Returns the probability that a pose with this recall is right, whatever its score: one half at
// 0.028, with a logit that rises by 6 with the logarithm of the recall. Fitted by maximum
// likelihood to 421 answers: KITTI frames on maps of ten, hard queries of two cities, Lund on every
// fourth photo.
double RecallConfidence(double view_recall);

}  // namespace cairn

#endif  // CAIRN_ENGINE_ANSWER_VIEW_RECALL_H_
