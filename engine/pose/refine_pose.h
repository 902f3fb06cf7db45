// Robust maximum-likelihood refinement of a pose in all six degrees of freedom, and its covariance.
#ifndef CAIRN_ENGINE_POSE_REFINE_POSE_H_
#define CAIRN_ENGINE_POSE_REFINE_POSE_H_

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/rigid3.h"
#include "engine/pose/pose_residuals.h"
#include "engine/query/query_context.h"

namespace cairn {

// A landmark and the pixel at which it was seen.
struct PoseObservation {
  Eigen::Vector2d pixel;
  Eigen::Vector3d x_in_anchor;
  double sigma_m = 0.0;  // Standard deviation of the landmark per axis.
  int camera_idx = 0;    // 0 is `camera` of RefinePose, i is other_cameras[i - 1].
  // If set, it weighs the error, and sigma_m does not count.
  std::optional<ErrorShape> error_shape = {};
};

// A measured direction of gravity.
struct GravityPrior {
  Eigen::Vector3d down_in_cam;  // Unit vector.
  double sigma_rad = 0.0;       // Standard deviation per axis; positive.
};

struct RefinePoseOptions {
  double keypoint_sigma_px = 1.0;  // Standard deviation of a keypoint per axis.
  int max_iterations = 10;
  // Iterations stop after a step that decreases the cost by a smaller share.
  double min_relative_decrease = 1e-6;
};

struct RefinedPose {
  Rigid3d cam_from_anchor;
  double cost = 0.0;       // Half the sum of the robust squared residuals.
  int num_iterations = 0;  // Number of accepted steps.
};

// Minimizes the Cauchy-robust reprojection errors in the true (distorted) image plus the squared
// gravity residual, by Levenberg-Marquardt from `initial_cam_from_anchor`. Each reprojection error
// is weighted by 1 / (keypoint_sigma_px^2 + (focal * sigma_m / distance)^2), or by its error_shape.
// An observation that does not project counts as a gross outlier. Works for any number of
// observations, in linear time. With fewer than three observations (two with gravity), the pose
// stays at or near the initial pose in the free directions. For a rig, the pose is that of
// `camera`, and all cameras move with it.
RefinedPose RefinePose(const Camera& camera, const std::vector<PoseObservation>& observations,
                       const std::optional<GravityPrior>& gravity,
                       const Rigid3d& initial_cam_from_anchor, const RefinePoseOptions& options,
                       std::span<const QueryRigCamera> other_cameras = {});

// Returns the covariance of a refined pose, as LocalizeResult::covariance. The arguments are those
// of RefinePose. keypoint_sigma_px and sigma_m weigh the observations against each other; how large
// the errors are, the residuals tell (robustly measured), and the part of the reprojections is
// scaled accordingly. Distances that err alike (ErrorShape::by_distance_px) add what they do to the
// pose. A direction that the observations leave free gets a large finite variance (about 3 rad, 1
// km).
Eigen::Matrix<double, 6, 6> PoseCovariance(const Camera& camera,
                                           const std::vector<PoseObservation>& observations,
                                           const std::optional<GravityPrior>& gravity,
                                           const Rigid3d& cam_from_anchor,
                                           const RefinePoseOptions& options,
                                           std::span<const QueryRigCamera> other_cameras = {});

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_REFINE_POSE_H_
