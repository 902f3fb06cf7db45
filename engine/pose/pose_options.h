// Options of the pose stage.
#ifndef CAIRN_ENGINE_POSE_POSE_OPTIONS_H_
#define CAIRN_ENGINE_POSE_POSE_OPTIONS_H_

#include "engine/pose/evidence/evidence_model.h"

namespace cairn {

// How a pose is computed from a minimal sample.
enum class MinimalSolver {
  kAuto,             // Two points and gravity if the query has gravity, else P3P.
  kGravityTwoPoint,  // Two points and gravity; a query without gravity gets no pose.
  kP3p,              // Three points; gravity enters the refinement only.
};

// How the gains of a pose are computed; both give the same but for rounding.
enum class ConsensusKernel {
  kVectorized,
  kPlain,  // One correspondence at a time: what the other is measured and tested against.
};

// How poses are scored, see ConsensusSet.
struct ConsensusOptions {
  ConsensusKernel kernel = ConsensusKernel::kVectorized;
  // Scoring stops as soon as a pose is unlikely to beat the best one.
  bool early_rejection = true;
  // Share of the good poses that may be rejected early, in (0, 1). Drawing another pose costs less
  // than looking at 100 correspondences, so losing a few is cheaper than being sure: 0.05 takes
  // 0.92 of the time of 0.005 at 5 % inliers, more gains nothing (cairn_pose_bench).
  double max_rejected_share = 0.05;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

struct PoseOptions {
  MinimalSolver solver = MinimalSolver::kAuto;
  // Reprojection error of an inlier, as an angle: pixels at a focal length of 500. A camera of
  // focal length f uses max_error_px * f / 500, at least 2 px (see MaxErrorPx).
  double max_error_px = 4.0;
  // Standard deviation of a keypoint's position per axis, pixels: what weighs keypoints against
  // landmark uncertainty and gravity, and what the covariance is at least based on.
  double keypoint_sigma_px = 1.0;
  int min_iterations = 50;
  int max_iterations = 2000;
  double success_probability = 0.999;  // Stop when an all-inlier sample was drawn with this.
  // How often a match is drawn into a sample falls with the squared distance of its descriptors, d:
  // as exp(-distance_weight * d / m), m that of a median pair of one landmark. 0 draws all alike.
  double distance_weight = 3.0;
  int num_local_optimizations = 2;  // Refinements each time a minimal model improves the score.
  int min_inliers = 6;              // Distinct keypoints; fewer is no estimate.
  // How far the direction of gravity may be off, radians (1 standard deviation per axis): a minimal
  // model's threshold is widened by it, the final refinement uses it as a weak prior.
  double gravity_sigma_rad = 0.0175;
  ConsensusOptions consensus;
  EvidenceModel evidence;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;

  // Inlier threshold in pixels of a camera.
  double MaxErrorPx(double focal_px) const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_POSE_OPTIONS_H_
