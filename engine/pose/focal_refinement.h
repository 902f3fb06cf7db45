// Refines the pose of an answer together with its camera.
#ifndef CAIRN_ENGINE_POSE_FOCAL_REFINEMENT_H_
#define CAIRN_ENGINE_POSE_FOCAL_REFINEMENT_H_

#include <optional>
#include <vector>

#include "engine/pose/pose_options.h"
#include "engine/pose/refine_camera.h"
#include "engine/query/pose_candidate.h"
#include "engine/query/query_context.h"

namespace cairn {

// A pose and the camera that was estimated with it.
struct EstimateWithCamera {
  PoseEstimate estimate;  // Its covariance comes from RefineCamera.
  RefinedCamera camera;
};

// Refines `estimate`, a pose under query.camera, together with the camera on the pose's inliers. A
// wrong focal length hides inliers, so the function gathers inliers again among `correspondences`
// under the new camera and repeats until they settle. Returns nothing if fewer than
// options.min_inliers remain. The query must not be a rig's. query.camera must equal the prior's
// camera except for the parameters that RefineCamera changes.
std::optional<EstimateWithCamera> RefineWithCamera(
    const QueryContext& query, const std::vector<Correspondence>& correspondences,
    PoseEstimate estimate, const CameraPrior& prior, const PoseOptions& options);

// The pose of an answer, and its camera if that differs from the query's.
struct AnsweredCamera {
  PoseEstimate estimate;                // Its covariance includes the camera's uncertainty.
  std::optional<RefinedCamera> camera;  // Empty if query.camera is kept.
};

// Refines the winner of a query. If the inliers contradict the prior, they were gathered with a
// wrong camera. The function then gathers them again with a camera that follows the inliers alone,
// before it applies the prior. If they contradict the principal point of a camera that is
// estimated, the prior is OffCenterPrior. If `keep_if_possible` is set, query.camera (then the
// prior's camera) and the pose stay unchanged unless the inliers contradict the prior
// significantly.
AnsweredCamera RefineAnswer(const QueryContext& query,
                            const std::vector<Correspondence>& correspondences,
                            PoseEstimate estimate, const CameraPrior& prior, bool keep_if_possible,
                            const PoseOptions& options);

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_FOCAL_REFINEMENT_H_
