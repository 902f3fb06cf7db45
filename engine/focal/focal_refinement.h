// The pose of an answer and its camera, refined together.
#ifndef CAIRN_ENGINE_FOCAL_FOCAL_REFINEMENT_H_
#define CAIRN_ENGINE_FOCAL_FOCAL_REFINEMENT_H_

#include <optional>
#include <vector>

#include "engine/pose/least_squares/refine_camera.h"
#include "engine/pose/pose_options.h"
#include "engine/query/pose_candidate.h"
#include "engine/query/query_context.h"

namespace cairn {

// A pose and the camera that goes with it.
struct EstimateWithCamera {
  PoseEstimate estimate;  // Its covariance is that of RefineCamera.
  RefinedCamera camera;
};

// Refines `estimate`, a pose under query.camera, and the camera on the pose's inliers, gathers
// these anew among `correspondences` under the new camera, and so on until they settle, since a
// wrong focal length hides inliers. Nothing if they become fewer than options.min_inliers. The
// query is not a rig's; query.camera is the prior's but for what RefineCamera changes.
std::optional<EstimateWithCamera> RefineWithCamera(
    const QueryContext& query, const std::vector<Correspondence>& correspondences,
    PoseEstimate estimate, const CameraPrior& prior, const PoseOptions& options);

// The pose of an answer and what is to be said of its camera.
struct AnsweredCamera {
  PoseEstimate estimate;                // Its covariance includes the camera's.
  std::optional<RefinedCamera> camera;  // Nothing: query.camera is kept.
};

// Refines the winner of a query. If the inliers contradict the prior, they are gathered with a
// camera that follows them alone before the prior is heard again, since they were gathered with a
// wrong one. With `keep_if_possible` query.camera, then the prior's, and the pose stay as they are
// unless the inliers significantly say otherwise.
AnsweredCamera RefineAnswer(const QueryContext& query,
                            const std::vector<Correspondence>& correspondences,
                            PoseEstimate estimate, const CameraPrior& prior, bool keep_if_possible,
                            const PoseOptions& options);

}  // namespace cairn

#endif  // CAIRN_ENGINE_FOCAL_FOCAL_REFINEMENT_H_
