#include "engine/pose/estimate_pose.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "core/angles.h"
#include "core/frames.h"
#include "engine/pose/evidence.h"
#include "engine/pose/pose_ransac_problem.h"
#include "engine/pose/ransac.h"
#include "engine/pose/refine_pose.h"

namespace cairn {
namespace {

Eigen::Vector2d PixelOf(const QueryContext& query, const Correspondence& correspondence) {
  const Keypoint& keypoint = query.keypoints[correspondence.keypoint_idx];
  return {keypoint.x_px, keypoint.y_px};
}

// Returns true if a point is so far from a keypoint's ray that its image cannot be within twice
// `max_error_px` of the keypoint. The test is cheaper than a projection. An image may be compressed
// by up to kMaxSqueeze relative to its middle.
bool IsFarFromRay(const QueryContext& query, int keypoint_idx, const Eigen::Vector3d& x_in_first,
                  double max_error_px) {
  constexpr double kMaxSqueeze = 10.0;
  const double max_sine =
      kMaxSqueeze * 2.0 * max_error_px / query.CameraOf(keypoint_idx).focal_px();
  const Eigen::Vector3d& ray = query.rays_in_cam[keypoint_idx];
  const Eigen::Vector3d to_point = x_in_first - query.OriginInCam(keypoint_idx);
  return max_sine < 1.0 &&
         ray.cross(to_point).squaredNorm() > max_sine * max_sine * to_point.squaredNorm();
}

// The reprojection error of a correspondence under the true camera.
struct MatchError {
  double ratio = std::numeric_limits<double>::infinity();  // Squared error over squared threshold.
  double sq_error_px = 0.0;

  bool IsInlier() const { return ratio < 1.0; }
};

// Returns the error under a pose; an infinite ratio if the landmark does not project near the
// keypoint.
MatchError ErrorOf(const QueryContext& query, const Correspondence& correspondence,
                   const Eigen::Matrix<double, 3, 4>& cam_from_anchor, const PoseOptions& options) {
  const int keypoint_idx = correspondence.keypoint_idx;
  const Camera& camera = query.CameraOf(keypoint_idx);
  const double max_error_px = options.MaxErrorPx(camera.focal_px());
  const Eigen::Vector3d x_in_first = cam_from_anchor * correspondence.x_in_anchor.homogeneous();
  if (IsFarFromRay(query, keypoint_idx, x_in_first, max_error_px)) {
    return {};
  }
  const Eigen::Vector3d x_in_cam = query.InCameraOf(keypoint_idx, x_in_first);
  const auto projected = camera.Project(x_in_cam);
  if (!projected) {
    return {};
  }
  // Widened by the landmark's uncertainty, as in ConsensusSet.
  const double landmark_px = std::min(
      3.0 * camera.focal_px() * correspondence.sigma_m / x_in_cam.norm(), 1.7320508 * max_error_px);
  const double sq_threshold_px = max_error_px * max_error_px + landmark_px * landmark_px;
  const double sq_error_px = (*projected - PixelOf(query, correspondence)).squaredNorm();
  return {sq_error_px / sq_threshold_px, sq_error_px};
}

// The best inlier of each keypoint under the true camera, in ascending order of keypoint.
struct InlierSet {
  std::vector<int> indices;  // Into the correspondences.
  double sum_sq_error_px = 0.0;
};

InlierSet GatherInliers(const QueryContext& query,
                        const std::vector<Correspondence>& correspondences,
                        const Rigid3d& cam_from_anchor, const PoseOptions& options) {
  struct Best {
    int index = -1;
    MatchError error = {.ratio = 1.0};
  };
  std::vector<Best> best(query.keypoints.size());
  const Eigen::Matrix<double, 3, 4> cam_from_anchor_matrix = cam_from_anchor.ToMatrix();
  for (size_t i = 0; i < correspondences.size(); ++i) {
    const MatchError error = ErrorOf(query, correspondences[i], cam_from_anchor_matrix, options);
    Best& entry = best[correspondences[i].keypoint_idx];
    if (error.ratio < entry.error.ratio) {
      entry = {static_cast<int>(i), error};
    }
  }
  InlierSet inliers;
  for (const Best& entry : best) {
    if (entry.index >= 0) {
      inliers.indices.push_back(entry.index);
      inliers.sum_sq_error_px += entry.error.sq_error_px;
    }
  }
  return inliers;
}

std::vector<PoseObservation> ObservationsOf(const QueryContext& query,
                                            const std::vector<Correspondence>& correspondences,
                                            const std::vector<int>& indices) {
  std::vector<PoseObservation> observations;
  observations.reserve(indices.size());
  for (const int index : indices) {
    observations.push_back(ObservationOf(query, correspondences[index]));
  }
  return observations;
}

// Returns the logarithm of the volume of a Gaussian, sqrt(det(2 pi covariance)).
double LogVolume(const Eigen::Matrix<double, 6, 6>& covariance) {
  const Eigen::Matrix<double, 6, 1> pivots =
      (2.0 * kPi * covariance).ldlt().vectorD().cwiseMax(std::numeric_limits<double>::min());
  return 0.5 * pivots.array().log().sum();
}

// Returns the logarithm of the density of tilts at a pose. The measured gravity may be grossly
// wrong, so the density is nowhere lower than without a measurement.
double LogTiltDensity(const std::optional<GravityPrior>& gravity, const Rigid3d& cam_from_anchor) {
  if (!gravity) {
    return 0.0;
  }
  const double sq_sigma = gravity->sigma_rad * gravity->sigma_rad;
  const Eigen::Vector3d down_in_cam = cam_from_anchor.rotation * DownInEnu();
  const double sq_sine = down_in_cam.cross(gravity->down_in_cam).squaredNorm();
  return std::max(0.0, -std::log(2.0 * kPi * sq_sigma) - 0.5 * sq_sine / sq_sigma);
}

// Fills the estimate for a pose that was refined on `refined_on`, which are some of its inliers.
void FillEstimate(const QueryContext& query, const std::vector<Correspondence>& correspondences,
                  const std::vector<PoseObservation>& refined_on, const Rigid3d& cam_from_anchor,
                  InlierSet inliers, const PoseOptions& options, PoseEstimate* estimate) {
  estimate->cam_from_anchor = cam_from_anchor;
  const std::optional<GravityPrior> gravity = MakeGravityPrior(query, options);
  estimate->covariance = PoseCovariance(query.camera, refined_on, gravity, cam_from_anchor,
                                        RefinementOf(options), query.other_cameras);
  estimate->log_volume = LogVolume(estimate->covariance);
  estimate->log_tilt_density = LogTiltDensity(gravity, cam_from_anchor);
  estimate->mean_sq_error_px =
      inliers.sum_sq_error_px / static_cast<double>(inliers.indices.size());
  PoseEvidence evidence = WeighEvidence(query, correspondences, inliers.indices, cam_from_anchor);
  estimate->evidence = evidence.log_ratio;
  estimate->right_probabilities = std::move(evidence.right_probabilities);
  estimate->inliers = std::move(inliers.indices);
}

}  // namespace

PoseObservation ObservationOf(const QueryContext& query, const Correspondence& correspondence) {
  return {PixelOf(query, correspondence), correspondence.x_in_anchor, correspondence.sigma_m,
          query.CameraIdxOf(correspondence.keypoint_idx)};
}

RefinePoseOptions RefinementOf(const PoseOptions& options) {
  RefinePoseOptions refine_options;
  refine_options.keypoint_sigma_px = options.keypoint_sigma_px;
  return refine_options;
}

std::vector<int> LikelyInliers(const PoseEstimate& estimate) {
  constexpr double kLikely = 0.5;
  std::vector<int> likely;
  for (size_t i = 0; i < estimate.inliers.size(); ++i) {
    if (estimate.right_probabilities[i] >= kLikely) {
      likely.push_back(estimate.inliers[i]);
    }
  }
  return likely;
}

std::optional<PoseEstimate> EstimatePose(const QueryContext& query,
                                         const std::vector<Correspondence>& correspondences,
                                         const std::vector<int>& subset, const PoseOptions& options,
                                         uint64_t seed, double min_consensus) {
  if (options.solver == MinimalSolver::kGravityTwoPoint && !query.level_from_cam) {
    return std::nullopt;
  }
  PoseRansacProblem problem(query, correspondences, subset, options, seed);
  if (problem.num_keypoints() < options.min_inliers ||
      problem.num_keypoints() <= min_consensus) {  // A keypoint gains at most 1.
    return std::nullopt;
  }
  const RansacOptions ransac_options = {.min_iterations = options.min_iterations,
                                        .max_iterations = options.max_iterations,
                                        .min_score = min_consensus};
  const auto ransac = LoRansac(&problem, ransac_options, seed);
  if (!ransac.model) {
    return std::nullopt;
  }
  PoseEstimate estimate;
  estimate.cam_from_anchor = {Eigen::Matrix3d(ransac.model->leftCols<3>()), ransac.model->col(3)};
  estimate.consensus = ransac.score;
  estimate.num_iterations = ransac.num_iterations;
  return RefineEstimate(query, correspondences, std::move(estimate), options);
}

std::vector<int> Unexplained(const QueryContext& query,
                             const std::vector<Correspondence>& correspondences,
                             const std::vector<int>& subset, const Rigid3d& cam_from_anchor,
                             const PoseOptions& options) {
  const Eigen::Matrix<double, 3, 4> cam_from_anchor_matrix = cam_from_anchor.ToMatrix();
  std::vector<int> unexplained;
  std::copy_if(subset.begin(), subset.end(), std::back_inserter(unexplained), [&](int index) {
    return !ErrorOf(query, correspondences[index], cam_from_anchor_matrix, options).IsInlier();
  });
  return unexplained;
}

std::optional<PoseEstimate> RefineEstimate(const QueryContext& query,
                                           const std::vector<Correspondence>& correspondences,
                                           PoseEstimate estimate, const PoseOptions& options) {
  constexpr int kMaxRounds = 4;
  const std::optional<GravityPrior> gravity = MakeGravityPrior(query, options);
  Rigid3d cam_from_anchor = estimate.cam_from_anchor;
  std::vector<PoseObservation> observations;
  InlierSet inliers = GatherInliers(query, correspondences, cam_from_anchor, options);
  for (int round = 0; round < kMaxRounds; ++round) {
    if (static_cast<int>(inliers.indices.size()) < options.min_inliers) {
      return std::nullopt;
    }
    observations = ObservationsOf(query, correspondences, inliers.indices);
    cam_from_anchor = RefinePose(query.camera, observations, gravity, cam_from_anchor,
                                 RefinementOf(options), query.other_cameras)
                          .cam_from_anchor;
    InlierSet next = GatherInliers(query, correspondences, cam_from_anchor, options);
    const bool settled = next.indices == inliers.indices;
    inliers = std::move(next);
    if (settled) {
      break;
    }
  }
  if (static_cast<int>(inliers.indices.size()) < options.min_inliers) {
    return std::nullopt;
  }
  FillEstimate(query, correspondences, observations, cam_from_anchor, std::move(inliers), options,
               &estimate);
  return estimate;
}

PoseEstimate RefineOnLikelyInliers(const QueryContext& query,
                                   const std::vector<Correspondence>& correspondences,
                                   PoseEstimate estimate, const PoseOptions& options) {
  constexpr int kMaxRounds = 3;
  for (int round = 0; round < kMaxRounds; ++round) {
    const std::vector<int> likely = LikelyInliers(estimate);
    if (static_cast<int>(likely.size()) < options.min_inliers ||
        likely.size() == estimate.inliers.size()) {
      return estimate;
    }
    const std::vector<PoseObservation> observations =
        ObservationsOf(query, correspondences, likely);
    const Rigid3d cam_from_anchor =
        RefinePose(query.camera, observations, MakeGravityPrior(query, options),
                   estimate.cam_from_anchor, RefinementOf(options), query.other_cameras)
            .cam_from_anchor;
    InlierSet inliers = GatherInliers(query, correspondences, cam_from_anchor, options);
    if (static_cast<int>(inliers.indices.size()) < options.min_inliers) {
      return estimate;
    }
    PoseEstimate refined = estimate;
    FillEstimate(query, correspondences, observations, cam_from_anchor, std::move(inliers), options,
                 &refined);
    if (refined.evidence <= estimate.evidence) {
      return estimate;
    }
    estimate = std::move(refined);
  }
  return estimate;
}

}  // namespace cairn
