// Bundle adjustment: poses, landmarks and cameras that explain all keypoints best.
#ifndef CAIRN_CORE_ADJUST_ADJUST_H_
#define CAIRN_CORE_ADJUST_ADJUST_H_

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/scene/reconstruction.h"

namespace cairn {

// What an adjustment may change of a camera that several images share, each more than the one
// before. The ratio of fx to fy never changes.
enum class CameraFreedom {
  kFixed,
  kFocal,
  // Also the two radial terms k1 and k2. A camera without them becomes RADIAL, or OPENCV if fx and
  // fy differ. The models other than SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL and OPENCV keep
  // their distortion: for them the freedom is kFocal.
  kFocalAndDistortion,
  kWithPrincipalPoint,  // Of a picture that was cut out of another.
};

// A known position of an image's camera.
struct CenterPrior {
  Eigen::Vector3d center_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Ones();  // Standard deviations along the world's axes.
};

// All optional. An empty vector stands for "none".
struct AdjustPriors {
  std::vector<std::optional<CenterPrior>> position_of_image;
  // Relative standard deviation of the focal length; 0: no prior.
  std::vector<double> focal_sigma_of_camera;
  // The cameras about which the priors of focal length and distortion hold; those at the start if
  // empty. A model that is adjusted many times would drift away from its priors without them.
  std::vector<Camera> camera_means;
  // Images whose pose is held, not 0: the rest of the model around the photos that a growth adds.
  std::vector<uint8_t> image_is_fixed;
  // Nonzero for a landmark whose position is held, since it belongs to a model that stays. One
  // observation that fits keeps such a landmark.
  std::vector<uint8_t> landmark_is_fixed;

  bool HoldsImage(size_t image) const {
    return !image_is_fixed.empty() && image_is_fixed[image] != 0;
  }
  bool HoldsLandmark(size_t landmark) const {
    return !landmark_is_fixed.empty() && landmark_is_fixed[landmark] != 0;
  }
};

struct AdjustOptions {
  // Scale of Cauchy's loss on the reprojection errors, in standard deviations of a keypoint
  // (KeypointSigmaPx). As in TriangulatePoint.
  double loss_scale_sigmas = 2.0;
  // Scale of Cauchy's loss on position priors, in their standard deviations.
  double position_loss_scale_sigmas = 2.0;
  // Standard deviation of k1 and of k2 about their start, where they are free: lenses that people
  // take photos with bend the corner of a picture, at a radius of 0.6, by some percent. It decides
  // only where the photos do not show the distortion.
  double distortion_sigma = 0.2;
  // Scale of Cauchy's loss on the shift of the principal point from its mean, where it is free, in
  // lengths of the picture's longer side. A whole picture has its principal point near its middle,
  // and a part of a picture may have it anywhere.
  double principal_point_loss_scale = 0.01;
  int max_iterations = 50;
  // The solver stops when the cost falls by less than this share.
  double min_relative_change = 1e-6;
  // After each solution, observations whose error is above this many standard deviations leave.
  // Of true observations with normal errors, 1 in 3,000 are above 4.
  double max_error_sigmas = 4.0;
  // Solutions at most. The last ones are needed only while observations leave.
  int max_rounds = 3;
  // Above this many observations, a solution takes the landmarks that most images see, enough for
  // each part of each picture, and the other landmarks follow with the poses held. A solution needs
  // some 0.8 kB an observation. With 500 of 3,500 observations an image, the errors of the poses
  // grow by a factor of 1.4 (docs/decisions/0071).
  int max_observations_of_all = 200'000;
  // Landmarks whose rays span less than this leave: their depths are anything.
  double min_ray_angle_rad = 0.0;
  // Threads that look for outliers. The result does not depend on them.
  int num_threads = 1;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

// Receives the iterations of the solver that are done and the most that there may be. If it throws,
// the adjustment ends with what it threw.
using AdjustProgress = std::function<void(int done, int most)>;

struct AdjustReport {
  int num_rounds = 0;
  int num_iterations = 0;
  double initial_cost = 0.0;  // Of the first solution; half the sum of the robust squared errors.
  double final_cost = 0.0;    // Of the last solution.
  double rms_px = 0.0;        // Of the reprojection errors that stayed.
  int64_t num_observations = 0;
  int64_t num_observations_removed = 0;
  int64_t num_landmarks_removed = 0;
};

// Changes the poses, the landmarks and, as `freedom_of_camera` (one for each camera) allows, the
// cameras of `model`. The unknowns minimize the robust reprojection errors, in units of the
// keypoints' standard deviations, plus the priors. docs/math/mapping_adjustment.md has
// the residuals.
//
// Observations that do not fit leave `model`, and landmarks of fewer than two observations leave it
// with them, so landmarks change their indices; their order stays. Images stay, even without an
// observation; those keep their poses.
//
// Gauge: with three position priors, two fixed images or three fixed landmarks nothing else is
// held. Otherwise one camera keeps its pose and the camera farthest from it keeps one coordinate of
// its center, unless an image is fixed. The scale of the world is then that of the start.
//
// The same result on any number of threads. Linear in the number of observations, apart from the
// factorization of the poses' system, which is sparse where the scene is long and dense where all
// photos see the same; hundreds of these are solved by iterations. If no step can be computed, the
// poses and the landmarks stay where they are. Throws Error(kInternal) if the solver fails; `model`
// is then, and if `progress` throws, somewhere between its start and the result.
AdjustReport Adjust(std::span<const CameraFreedom> freedom_of_camera, const AdjustPriors& priors,
                    const AdjustOptions& options, Reconstruction& model,
                    const AdjustProgress& progress = {});

}  // namespace cairn

#endif  // CAIRN_CORE_ADJUST_ADJUST_H_
