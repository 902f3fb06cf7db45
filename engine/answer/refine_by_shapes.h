// Refines the winning pose with the shapes of the errors of its landmarks.
#ifndef CAIRN_ENGINE_ANSWER_REFINE_BY_SHAPES_H_
#define CAIRN_ENGINE_ANSWER_REFINE_BY_SHAPES_H_

#include <vector>

#include "engine/pose/pose_hypotheses.h"
#include "engine/pose/pose_options.h"
#include "engine/query/localize_query.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

// Refines the pose once more on its likely inliers, and the camera, too, if that was estimated.
// Until here a landmark is as uncertain along each axis; now its error has the shape of
// ShapeOfLandmark. The evidence and the volume of the pose stay: scores compare poses whose
// landmarks have round errors. The arguments are those of RefineWinner.
PoseHypothesis RefineByShapes(const QueryContext& query, const LocalizeQuery& stated,
                              const std::vector<TileView>& tiles, PoseHypothesis winner,
                              const PoseOptions& options);

}  // namespace cairn

#endif  // CAIRN_ENGINE_ANSWER_REFINE_BY_SHAPES_H_
