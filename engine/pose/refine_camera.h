// Robust maximum-likelihood refinement of a pose together with the camera's focal length and, on
// request, its principal point and radial distortion. Kept apart from RefinePose, which is called
// far more often.
#ifndef CAIRN_ENGINE_POSE_REFINE_CAMERA_H_
#define CAIRN_ENGINE_POSE_REFINE_CAMERA_H_

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/camera.h"
#include "core/focal_length.h"
#include "engine/pose/refine_pose.h"

namespace cairn {

// Prior knowledge of a camera. The logarithm of its focal length has a Gaussian error.
struct CameraPrior {
  Camera camera;
  FocalPrior focal;
  bool is_off_center = false;  // The photo is taken for a part of another one (OffCenterPrior).
  // Standard deviation of the radial coefficient if the prior is `with_distortion`. Phone photos
  // have coefficients of -0.1 to 0.1.
  double radial_sigma = 0.05;
  // Standard deviation of the principal point per axis, as a share of the long side of the image;
  // 0: it is known.
  double principal_point_sigma = 0.0;
  // Standard deviation of the logarithm of fx / fy unless the principal point is known. Pixels are
  // square, but not quite: Herz-Jesus has 0.0017, KITTI 0.
  double aspect_sigma = 0.001;
};

struct RefinedCamera {
  Camera camera;
  Rigid3d cam_from_anchor;
  bool is_off_center = false;  // As in the prior.
  // Of the pose, as LocalizeResult::covariance before calibration: marginalized over the camera.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double focal_log_sigma = 0.0;  // Standard deviation of the logarithm of the focal length.
  // The larger standard deviation of the principal point's coordinates; 0 if it is known.
  double principal_point_sigma_px = 0.0;
  // The difference between the focal lengths of the prior and of the observations alone:
  // focal_disagreement is in standard deviations of the difference, focal_significance in standard
  // deviations of the observations.
  double focal_disagreement = 0.0;
  double focal_significance = 0.0;

  double principal_point_disagreement = 0.0;  // As focal_disagreement; of the axis that has more.

  bool FocalDisagrees() const { return focal_disagreement > kMaxDisagreement; }
  static constexpr double kMaxDisagreement = 3.0;
};

// Minimizes the cost of RefinePose plus the squared errors of the prior over the pose, the
// logarithm of the focal length, with distortion the radial coefficient and, unless the principal
// point is known, the principal point and the logarithm of fx / fy. Starts from `initial_camera`,
// which must equal the prior's camera except for these parameters, and for the model that has them:
// WithTwoFocalLengths, as the result. `camera_idx` of the observations must be 0.
//
// The Jacobian of a pixel u with respect to ln f is u - c, where c is the principal point, and that
// with respect to c is the identity. If depth and focal length cannot be separated, the prior
// determines the focal length and the covariance reflects the uncertainty. The prior's weight
// scales with the residuals as the covariance does (see ResidualSpread), where that is up. If prior
// and observations disagree, the covariance includes the distance by which the prior pulls the
// focal length away from the observations.
RefinedCamera RefineCamera(const CameraPrior& prior, const Camera& initial_camera,
                           const std::vector<PoseObservation>& observations,
                           const std::optional<GravityPrior>& gravity,
                           const Rigid3d& initial_cam_from_anchor,
                           const RefinePoseOptions& options);

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_REFINE_CAMERA_H_
