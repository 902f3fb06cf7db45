// Options of the pose stage.
#ifndef CAIRN_ENGINE_POSE_POSE_OPTIONS_H_
#define CAIRN_ENGINE_POSE_POSE_OPTIONS_H_

namespace cairn {

// How a pose is computed from a minimal sample.
enum class MinimalSolver {
  kAuto,             // Two points and gravity if the query has gravity, else P3P.
  kGravityTwoPoint,  // Two points and gravity; a query without gravity gets no pose.
  kP3p,              // Three points; gravity is used only in the refinement.
};

// How the gains of a pose are computed. Both kernels give the same results up to rounding.
enum class ConsensusKernel {
  kVectorized,
  kPlain,  // One correspondence at a time; the reference for tests and measurements.
};

// How poses are scored; see ConsensusSet. Only tests and benchmarks change the defaults.
struct ConsensusOptions {
  ConsensusKernel kernel = ConsensusKernel::kVectorized;
  // Stops scoring a pose once it is unlikely to beat the best one.
  bool early_rejection = true;
};

struct PoseOptions {
  MinimalSolver solver = MinimalSolver::kAuto;
  // Largest reprojection error of an inlier, as an angle: in pixels at a focal length of 500 px. A
  // camera of focal length f uses max_error_px * f / 500, at least 2 px (see MaxErrorPx).
  double max_error_px = 4.0;
  // Standard deviation of a keypoint's position per axis, pixels. Determines the weight of
  // keypoints against landmark uncertainty and gravity, and a lower bound of the covariance.
  double keypoint_sigma_px = 1.0;
  int min_iterations = 50;
  int max_iterations = 2000;
  // The weight of a match in sampling falls with the squared distance d of its descriptors, as
  // exp(-distance_weight * d / m), where m is the squared distance of a median pair of one
  // landmark. 0 gives all matches the same weight.
  double distance_weight = 3.0;
  int min_inliers = 6;  // Distinct keypoints; a pose with fewer is not an estimate.
  // Standard deviation of the gravity direction per axis, radians. Widens the threshold of minimal
  // models and weights gravity as a weak prior in the final refinement.
  double gravity_sigma_rad = 0.0175;
  ConsensusOptions consensus;

  // Throws Error(kInvalidArgument), naming the field.
  void Validate() const;

  // Returns the inlier threshold of a camera, pixels.
  double MaxErrorPx(double focal_px) const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_POSE_OPTIONS_H_
