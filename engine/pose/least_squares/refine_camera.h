// Robust maximum-likelihood refinement of a pose together with the camera's focal length and, if
// asked for, its radial distortion. Apart from RefinePose, which is called far more often.
#ifndef CAIRN_ENGINE_POSE_LEAST_SQUARES_REFINE_CAMERA_H_
#define CAIRN_ENGINE_POSE_LEAST_SQUARES_REFINE_CAMERA_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/camera.h"
#include "core/focal_length.h"
#include "engine/pose/least_squares/refine_pose.h"

namespace cairn {

// What is known of the camera beforehand: its focal length but for a Gaussian error of its
// logarithm.
struct CameraPrior {
  Camera camera;
  FocalPrior focal;
  // Standard deviation of the radial coefficient of a camera `with_distortion`. Photos of phones
  // have -0.1 to 0.1.
  double radial_sigma = 0.05;
};

struct RefinedCamera {
  Camera camera;
  Rigid3d cam_from_anchor;
  // As LocalizeResult::covariance, over whatever focal length and distortion may be.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double focal_log_sigma = 0.0;  // Standard deviation of the logarithm of the focal length.
  // How far apart the prior and the observations alone are in the focal length: in standard
  // deviations of their difference, and of what the observations say.
  double focal_disagreement = 0.0;
  double focal_significance = 0.0;

  bool FocalDisagrees() const { return focal_disagreement > kMaxDisagreement; }
  static constexpr double kMaxDisagreement = 3.0;
};

// Minimises what RefinePose minimises plus the squared errors of the prior, over the pose, the
// logarithm of the focal length and, with distortion, the radial coefficient, starting from
// `initial_camera`, a camera as the prior's but for these. `camera_idx` of the observations is 0.
//
// The Jacobian of a pixel u by ln f is u - c, c being the principal point. Where depth and focal
// length exchange, the prior holds the latter and the covariance says the rest. The prior's weight
// grows with the residuals as the covariance does, see ResidualSpread. If the two disagree, the
// covariance includes how far the prior then pulls the focal length off what the observations say.
RefinedCamera RefineCamera(const CameraPrior& prior, const Camera& initial_camera,
                           const std::vector<PoseObservation>& observations,
                           const std::optional<GravityPrior>& gravity,
                           const Rigid3d& initial_cam_from_anchor,
                           const RefinePoseOptions& options);

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_LEAST_SQUARES_REFINE_CAMERA_H_
