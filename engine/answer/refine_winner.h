// Refines the winning pose on all of its evidence.
#ifndef CAIRN_ENGINE_ANSWER_REFINE_WINNER_H_
#define CAIRN_ENGINE_ANSWER_REFINE_WINNER_H_

#include <vector>

#include "engine/pose/pose_hypotheses.h"
#include "engine/pose/pose_options.h"
#include "engine/query/localize_query.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

// Refines the winner on the matches of all poses that might have won. If it has at least
// `sure_evidence`, also on the matches that it predicts (GuidedMatches). Then refines it on its
// likely inliers, and together with the camera if the query or the inliers require it, and at last
// with the shapes of the landmarks' errors (RefineByShapes). `query` is the context in which the
// winner was found; `stated` holds what the client knows about the camera.
PoseHypothesis RefineWinner(const QueryContext& query, const LocalizeQuery& stated,
                            const std::vector<TileView>& tiles, const PoseHypotheses& hypotheses,
                            const PoseHypothesis& winner, const PoseOptions& options,
                            double sure_evidence);

}  // namespace cairn

#endif  // CAIRN_ENGINE_ANSWER_REFINE_WINNER_H_
