#include "engine/pose/focal_refinement.h"

#include <cmath>
#include <utility>

#include "engine/pose/estimate_pose.h"
#include "engine/pose/focal_search.h"
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

// Returns the pose and camera of a photo that was cut out of another, not around its middle;
// nothing unless the inliers show that it was: by their evidence, or because they contradict a
// principal point in the middle. `centered` is the estimate with the query's prior. The focal
// length of a whole photo may be as wrong as that of a part, so the two are compared with the same
// freedom of it.
std::optional<EstimateWithCamera> RefineOffCenter(
    const QueryContext& query, const std::vector<Correspondence>& correspondences,
    const EstimateWithCamera& centered, const CameraPrior& prior, const PoseOptions& options) {
  constexpr double kDecisiveEvidence = 10.0, kDecisiveDisagreement = 6.0;
  const CameraPrior off_center = OffCenterPrior(prior);
  CameraPrior whole = prior;
  whole.focal.log_sigma = off_center.focal.log_sigma;
  const auto as_whole = RefineWithCamera(query, correspondences, centered.estimate, whole, options);
  auto as_part = RefineWithCamera(query, correspondences, centered.estimate, off_center, options);
  if (!as_whole || !as_part) {
    return std::nullopt;
  }
  const double gain = as_part->estimate.evidence - as_whole->estimate.evidence;
  const bool is_contradicted =
      as_whole->camera.principal_point_disagreement > kDecisiveDisagreement && gain >= 0.0;
  return gain > kDecisiveEvidence || is_contradicted ? std::move(as_part) : std::nullopt;
}

}  // namespace

std::optional<EstimateWithCamera> RefineWithCamera(
    const QueryContext& query, const std::vector<Correspondence>& correspondences,
    PoseEstimate estimate, const CameraPrior& prior, const PoseOptions& options) {
  constexpr int kMaxRounds = 8;
  // The camera has settled once it moves by less than this share of its standard deviations.
  constexpr double kSettledShare = 0.1;
  QueryContext seen = query;
  RefinedCamera refined;
  for (int round = 0; round < kMaxRounds; ++round) {
    const Camera last = seen.camera;
    refined = RefineCameraOnInliers(seen, correspondences, estimate, prior, options);
    const bool has_settled = std::abs(std::log(refined.camera.focal_px() / last.focal_px())) <
                                 kSettledShare * refined.focal_log_sigma &&
                             (PrincipalPointPx(refined.camera) - PrincipalPointPx(last)).norm() <=
                                 kSettledShare * refined.principal_point_sigma_px;
    seen = WithCamera(std::move(seen), refined.camera);
    PoseEstimate moved = estimate;
    moved.cam_from_anchor = refined.cam_from_anchor;
    auto next = RefineEstimate(seen, correspondences, std::move(moved), options);
    if (!next) {
      return std::nullopt;
    }
    const bool is_done = has_settled || next->inliers == estimate.inliers;
    estimate = std::move(*next);
    if (is_done) {
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
  if (refined && prior.principal_point_sigma > 0.0) {
    if (auto off_center = RefineOffCenter(WithCamera(query, refined->camera.camera),
                                          correspondences, *refined, prior, options)) {
      refined = std::move(off_center);
    }
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
