#include "engine/pose/focal_refinement.h"

#include <cmath>
#include <utility>

#include "engine/pose/estimate_pose.h"
#include "engine/pose/pose_ransac_problem.h"
#include "engine/query/build_query_context.h"

namespace cairn {
namespace {

// Refines pose and camera without changing the set of inliers.
RefinedCamera RefineCameraOnInliers(const QueryContext& query,
                                    const std::vector<Correspondence>& correspondences,
                                    const PoseEstimate& estimate, const CameraPrior& prior,
                                    const PoseOptions& options) {
  std::vector<PoseObservation> observations;
  observations.reserve(estimate.inliers.size());
  for (const int inlier : estimate.inliers) {
    observations.push_back(ObservationOf(query, correspondences[inlier]));
  }
  return RefineCamera(prior, query.camera, observations, MakeGravityPrior(query, options),
                      estimate.cam_from_anchor, RefinementOf(options));
}

}  // namespace

std::optional<EstimateWithCamera> RefineWithCamera(
    const QueryContext& query, const std::vector<Correspondence>& correspondences,
    PoseEstimate estimate, const CameraPrior& prior, const PoseOptions& options) {
  constexpr int kMaxRounds = 8;
  // The focal length has settled once it moves by less than this share of its standard deviation.
  constexpr double kSettledShare = 0.1;
  QueryContext seen = query;
  RefinedCamera refined;
  for (int round = 0; round < kMaxRounds; ++round) {
    const double last_focal_px = seen.camera.focal_px();
    refined = RefineCameraOnInliers(seen, correspondences, estimate, prior, options);
    const double moved_by = std::abs(std::log(refined.camera.focal_px() / last_focal_px));
    seen = WithCamera(std::move(seen), refined.camera);
    PoseEstimate moved = estimate;
    moved.cam_from_anchor = refined.cam_from_anchor;
    auto next = RefineEstimate(seen, correspondences, std::move(moved), options);
    if (!next) {
      return std::nullopt;
    }
    const bool settled =
        next->inliers == estimate.inliers || moved_by < kSettledShare * refined.focal_log_sigma;
    estimate = std::move(*next);
    if (settled) {
      break;
    }
  }
  estimate.covariance = refined.covariance;
  return EstimateWithCamera{std::move(estimate), std::move(refined)};
}

AnsweredCamera RefineAnswer(const QueryContext& query,
                            const std::vector<Correspondence>& correspondences,
                            PoseEstimate estimate, const CameraPrior& prior, bool keep_if_possible,
                            const PoseOptions& options) {
  // Standard deviation of a prior so weak that the inliers alone determine the focal length.
  constexpr double kLooseLogSigma = 0.2;
  constexpr double kSuspicious = 1.5, kSignificant = 3.0;
  const RefinedCamera near =
      RefineCameraOnInliers(query, correspondences, estimate, prior, options);
  std::optional<EstimateWithCamera> alone;
  if (near.focal_significance > kSuspicious && prior.focal.log_sigma < kLooseLogSigma) {
    CameraPrior loose = prior;
    loose.focal.log_sigma = kLooseLogSigma;
    alone = RefineWithCamera(query, correspondences, estimate, loose, options);
  }
  const bool is_contradicted = alone && alone->camera.focal_significance > kSignificant &&
                               alone->estimate.evidence >= estimate.evidence;
  std::optional<EstimateWithCamera> refined;
  if (is_contradicted) {
    refined = RefineWithCamera(WithCamera(query, alone->camera.camera), correspondences,
                               std::move(alone->estimate), prior, options);
  } else if (!keep_if_possible) {
    refined = RefineWithCamera(query, correspondences, estimate, prior, options);
  }
  if (refined) {
    return {std::move(refined->estimate), std::move(refined->camera)};
  }
  estimate.doubts_camera = near.focal_significance > kSuspicious;
  if (estimate.doubts_camera) {
    estimate.covariance = near.covariance;
  }
  return {std::move(estimate), std::nullopt};
}

}  // namespace cairn
