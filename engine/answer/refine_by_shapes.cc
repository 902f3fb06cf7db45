#include "engine/answer/refine_by_shapes.h"

#include <optional>

#include "engine/pose/estimate_pose.h"
#include "engine/pose/focal_search.h"
#include "engine/pose/pose_ransac_problem.h"
#include "engine/pose/pose_residuals.h"
#include "engine/pose/refine_camera.h"
#include "engine/query/build_query_context.h"
#include "engine/tiles/shape_of_landmark.h"

namespace cairn {
namespace {

std::vector<PosedCamera> CamerasAt(const QueryContext& query, const Rigid3d& cam_from_anchor) {
  std::vector<PosedCamera> cameras;
  for (int i = 0; i < query.num_cameras(); ++i) {
    cameras.emplace_back(query.CameraAt(i), (query.OwnFromFirst(i) * cam_from_anchor).Inverse());
  }
  return cameras;
}

// The likely inliers of the winner.
std::vector<PoseObservation> ShapedObservations(const QueryContext& query,
                                                const std::vector<TileView>& tiles,
                                                const PoseHypothesis& winner,
                                                const PoseOptions& options) {
  const std::vector<PosedCamera> cameras = CamerasAt(query, winner.estimate.cam_from_anchor);
  std::vector<PoseObservation> observations;
  for (const int inlier : LikelyInliers(winner.estimate)) {
    const Correspondence& match = (*winner.correspondences)[inlier];
    const TileView& view = tiles[match.tile_idx];
    PoseObservation& observation = observations.emplace_back(ObservationOf(query, match));
    observation.error_shape =
        ErrorShapeAt(cameras[observation.camera_idx], match.x_in_anchor,
                     ShapeOfLandmark(*view.tile, match.landmark_idx)
                         .Rotated(view.anchor_from_tile.rotation.toRotationMatrix()),
                     options.keypoint_sigma_px);
  }
  return observations;
}

}  // namespace

PoseHypothesis RefineByShapes(const QueryContext& query, const LocalizeQuery& stated,
                              const std::vector<TileView>& tiles, PoseHypothesis winner,
                              const PoseOptions& options) {
  const QueryContext seen = winner.camera ? WithCamera(query, winner.camera->camera) : query;
  const std::vector<PoseObservation> observations =
      ShapedObservations(seen, tiles, winner, options);
  if (static_cast<int>(observations.size()) < options.min_inliers) {
    return winner;
  }
  PoseEstimate& estimate = winner.estimate;
  const std::optional<GravityPrior> gravity = MakeGravityPrior(seen, options);
  const RefinePoseOptions refinement = RefinementOf(options);
  if (!winner.camera) {
    estimate.cam_from_anchor = RefinePose(seen.camera, observations, gravity,
                                          estimate.cam_from_anchor, refinement, seen.other_cameras)
                                   .cam_from_anchor;
    estimate.covariance = PoseCovariance(seen.camera, observations, gravity,
                                         estimate.cam_from_anchor, refinement, seen.other_cameras);
  }
  if (winner.camera || estimate.doubts_camera) {
    const CameraPrior prior = CameraPriorOf(stated);
    const bool is_off_center = winner.camera && winner.camera->is_off_center;
    const RefinedCamera refined =
        RefineCamera(is_off_center ? OffCenterPrior(prior) : prior, seen.camera, observations,
                     gravity, estimate.cam_from_anchor, refinement);
    estimate.covariance = refined.covariance;
    if (winner.camera) {
      estimate.cam_from_anchor = refined.cam_from_anchor;
      winner.camera = MakeCameraEstimate(prior, refined);
    }
  }
  return winner;
}

}  // namespace cairn
