// Refines the winning pose on all of its evidence.
#ifndef CAIRN_ENGINE_ANSWER_REFINE_WINNER_H_
#define CAIRN_ENGINE_ANSWER_REFINE_WINNER_H_

#include "engine/pose/pose_hypotheses.h"
#include "engine/pose/pose_options.h"
#include "engine/query/localize_query.h"

namespace cairn {

// Refines the winner on the matches of all poses that might have won, then on its likely inliers.
// Then refines pose and camera together if the query or the inliers require it. `query` is the
// context in which the winner was found; `stated` holds what the client knows about the camera.
PoseHypothesis RefineWinner(const QueryContext& query, const LocalizeQuery& stated,
                            const PoseHypotheses& hypotheses, const PoseHypothesis& winner,
                            const PoseOptions& options);

}  // namespace cairn

#endif  // CAIRN_ENGINE_ANSWER_REFINE_WINNER_H_
