// From pose hypotheses to the answer: which one wins, whether it may be trusted, what is reported.
#ifndef CAIRN_ENGINE_ANSWER_ANSWER_H_
#define CAIRN_ENGINE_ANSWER_ANSWER_H_

#include <functional>
#include <vector>

#include "engine/answer/answer_options.h"
#include "engine/pose/pose_hypotheses.h"
#include "engine/query/localize_result.h"
#include "engine/query/query_context.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

// Picks the hypothesis with the highest score, or another that has about as high a score and
// explains clearly more keypoints, lets `refine` refine it, and fills the result: its pose,
// accuracy, score, confidence and matches; or the reason why there is no answer: kAmbiguous (see
// AnswerOptions), kPriorMismatch if the score is too low only because the pose is far from the
// prior, kTooFewInliers. `hypotheses` must not be empty.
void ConcludeAnswer(const QueryContext& query, const std::vector<TileView>& tiles,
                    const std::vector<PoseHypothesis>& hypotheses, const AnswerOptions& options,
                    const std::function<PoseHypothesis(const PoseHypothesis&)>& refine,
                    LocalizeResult* result);

}  // namespace cairn

#endif  // CAIRN_ENGINE_ANSWER_ANSWER_H_
