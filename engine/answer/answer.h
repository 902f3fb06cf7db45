// Turns pose hypotheses into an answer: picks the winner, decides whether to trust it, and fills
// the result.
#ifndef CAIRN_ENGINE_ANSWER_ANSWER_H_
#define CAIRN_ENGINE_ANSWER_ANSWER_H_

#include <functional>
#include <vector>

#include "core/rigid3.h"
#include "engine/answer/answer_options.h"
#include "engine/pose/pose_hypotheses.h"
#include "engine/query/localize_result.h"
#include "engine/query/query_context.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

// Returns true if two poses, each cam_from_anchor, cannot both be the answer.
bool AreFarApart(const Rigid3d& a, const Rigid3d& b, const AnswerOptions& options);

// Picks the hypothesis with the highest score, or a hypothesis with about as high a score that
// explains clearly more keypoints. Passes the winner to `refine`. Returns `result` with the refined
// pose, its accuracy, score, confidence and matches. If there is no answer, returns it with the
// reason:
//  - kAmbiguous: see AnswerOptions;
//  - kPriorMismatch: the score is too low only because the pose is far from the prior;
//  - kTooFewInliers: otherwise; also if the camera was estimated and the pose is more likely wrong
//    than right, because the inliers leave the distance open along with the focal length.
// `hypotheses` must not be empty.
LocalizeResult ConcludeAnswer(const QueryContext& query, const std::vector<TileView>& tiles,
                              const std::vector<PoseHypothesis>& hypotheses,
                              const AnswerOptions& options,
                              const std::function<PoseHypothesis(const PoseHypothesis&)>& refine,
                              LocalizeResult result);

}  // namespace cairn

#endif  // CAIRN_ENGINE_ANSWER_ANSWER_H_
