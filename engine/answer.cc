#include "engine/answer.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/check.h"
#include "engine/refinement/bernoulli_divergence.h"

namespace cairn {
namespace {

bool WithinRegion(const SearchRegion& region, const Rigid3d& cam_from_anchor) {
  const Eigen::Vector3d center_in_anchor = cam_from_anchor.Inverse().translation;
  return !region.has_prior ||
         (center_in_anchor.head<2>() - region.prior_xy_in_anchor).norm() <= region.radius_m;
}

bool AreFarApart(const Rigid3d& a, const Rigid3d& b, const AnswerOptions& options) {
  return (a.Inverse().translation - b.Inverse().translation).norm() >
             options.ambiguous_distance_m ||
         RotationAngleRad(a.rotation, b.rotation) > options.ambiguous_rotation_rad;
}

std::vector<int> SortedKeypoints(const PoseHypothesis& hypothesis) {
  std::vector<int> keypoints;
  for (const int inlier : hypothesis.estimate.inliers) {
    keypoints.push_back((*hypothesis.correspondences)[inlier].keypoint_idx);
  }
  std::sort(keypoints.begin(), keypoints.end());
  return keypoints;
}

// True if the inliers decide between two poses that are far apart. What both explain, such as a
// facade that repeats, tells nothing; see AnswerOptions.
bool Outdoes(const PoseHypothesis& a, const PoseHypothesis& b, const AnswerOptions& options) {
  const std::vector<int> of_a = SortedKeypoints(a), of_b = SortedKeypoints(b);
  std::vector<int> shared;
  std::set_intersection(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(),
                        std::back_inserter(shared));
  const auto num_for = static_cast<double>(of_a.size() - shared.size());
  const auto num_against = static_cast<double>(of_b.size() - shared.size());
  const double num_all = num_for + num_against;
  return num_for > num_against &&
         static_cast<double>(of_b.size()) <=
             options.decisive_inlier_share * static_cast<double>(of_a.size()) &&
         num_all * BernoulliDivergence(num_for / num_all, 0.5) >= options.decisive_evidence;
}

// True if `rival` explains the image about as well as `best` from somewhere else.
bool Rivals(const PoseHypothesis& rival, const PoseHypothesis& best, const AnswerOptions& options) {
  return rival.estimate.effective_inliers >=
             options.ambiguous_score_ratio * best.estimate.effective_inliers &&
         AreFarApart(best.estimate.cam_from_anchor, rival.estimate.cam_from_anchor, options);
}

// The hypothesis that wins, `by_score` being in order; null if the answer is ambiguous.
const PoseHypothesis* FindWinner(const std::vector<const PoseHypothesis*>& by_score,
                                 const AnswerOptions& options) {
  const PoseHypothesis* best = by_score.front();
  for (const PoseHypothesis* rival : by_score) {
    if (Rivals(*rival, *best, options) && Outdoes(*rival, *best, options)) {
      best = rival;
    }
  }
  const bool is_ambiguous =
      std::any_of(by_score.begin(), by_score.end(), [&](const PoseHypothesis* rival) {
        return Rivals(*rival, *best, options) && !Outdoes(*best, *rival, options);
      });
  return is_ambiguous ? nullptr : best;
}

// Radius that holds 68 % of an isotropic Gaussian with this covariance trace: the square root of
// the 0.68 quantile of chi-squared with three degrees of freedom, 3.506.
double Radius68(const Eigen::Matrix3d& covariance) {
  return std::sqrt(3.506 * covariance.trace() / 3.0);
}

void FillMatches(const QueryContext& query, const std::vector<TileView>& tiles,
                 const PoseHypothesis& hypothesis, LocalizeResult* result) {
  std::vector<int> first_keypoint(query.num_cameras(), 0);
  for (int i = query.is_rig() ? query.num_keypoints() - 1 : -1; i >= 0; --i) {
    first_keypoint[query.CameraIdxOf(i)] = i;
  }
  for (const int inlier : hypothesis.estimate.inliers) {
    const Correspondence& match = (*hypothesis.correspondences)[inlier];
    const Keypoint& keypoint = query.keypoints[match.keypoint_idx];
    LocalizeMatch out;
    out.camera_idx = query.CameraIdxOf(match.keypoint_idx);
    out.keypoint_idx = match.keypoint_idx - first_keypoint[out.camera_idx];
    out.pixel = {keypoint.x_px, keypoint.y_px};
    out.landmark_id = tiles[match.tile_idx].tile->landmarks().landmark_ids[match.landmark_idx];
    out.tile_idx = match.tile_idx;
    out.x_in_anchor = match.x_in_anchor;
    out.sigma_m = match.sigma_m;
    const Camera& camera =
        hypothesis.camera ? hypothesis.camera->camera : query.CameraOf(match.keypoint_idx);
    const auto pixel = camera.Project(query.InCameraOf(
        match.keypoint_idx, hypothesis.estimate.cam_from_anchor * match.x_in_anchor));
    CAIRN_CHECK(pixel.has_value(), "an inlier projects into the image");
    out.error_px = (*pixel - out.pixel).norm();
    result->matches.push_back(out);
  }
  std::sort(result->matches.begin(), result->matches.end(),
            [](const LocalizeMatch& a, const LocalizeMatch& b) {
              return std::pair(a.camera_idx, a.keypoint_idx) <
                     std::pair(b.camera_idx, b.keypoint_idx);
            });
}

void FillPose(const QueryContext& query, const PoseEstimate& estimate,
              const ScoreCalibration& calibration, LocalizeResult* result) {
  result->localized = true;
  result->anchor = query.region.origin;
  result->cam_from_anchor = estimate.cam_from_anchor;
  result->cam_from_ecef = estimate.cam_from_anchor * query.region.ecef_from_anchor.Inverse();
  result->position = GeodeticFromEcef(result->cam_from_ecef.Inverse().translation);
  result->covariance = estimate.covariance;
  result->rotation_accuracy_rad =
      calibration.RotationAccuracyRad(Radius68(estimate.covariance.topLeftCorner<3, 3>()));
  result->position_accuracy_m =
      calibration.PositionAccuracyM(Radius68(estimate.covariance.bottomRightCorner<3, 3>()));
  result->score = estimate.effective_inliers;
  result->confidence = calibration.Confidence(result->score);
}

}  // namespace

void ConcludeAnswer(const QueryContext& query, const std::vector<TileView>& tiles,
                    const std::vector<PoseHypothesis>& hypotheses, const AnswerOptions& options,
                    const std::function<PoseHypothesis(const PoseHypothesis&)>& refine,
                    LocalizeResult* result) {
  CAIRN_CHECK(!hypotheses.empty(), "there is nothing to conclude from");
  std::vector<const PoseHypothesis*> by_score;
  bool good_one_outside = false;
  const auto is_good = [&](const PoseHypothesis& hypothesis) {
    return hypothesis.estimate.effective_inliers >= options.min_effective_inliers;
  };
  for (const PoseHypothesis& hypothesis : hypotheses) {
    if (WithinRegion(query.region, hypothesis.estimate.cam_from_anchor)) {
      by_score.push_back(&hypothesis);
    } else {
      good_one_outside |= is_good(hypothesis);
    }
  }
  const NotLocalizedReason nothing_good =
      good_one_outside ? NotLocalizedReason::kPriorMismatch : NotLocalizedReason::kTooFewInliers;
  if (by_score.empty()) {
    result->reason = nothing_good;
    return;
  }
  std::stable_sort(by_score.begin(), by_score.end(),
                   [](const PoseHypothesis* a, const PoseHypothesis* b) {
                     return a->estimate.effective_inliers > b->estimate.effective_inliers;
                   });
  const PoseHypothesis* winner = FindWinner(by_score, options);
  if (winner == nullptr) {
    result->reason = is_good(*by_score.front()) ? NotLocalizedReason::kAmbiguous : nothing_good;
    return;
  }
  const PoseHypothesis refined = refine(*winner);
  if (!is_good(refined) || !WithinRegion(query.region, refined.estimate.cam_from_anchor)) {
    result->reason = nothing_good;
    return;
  }
  result->reason = NotLocalizedReason::kNone;
  result->counters.used_gravity = refined.used_gravity;
  FillPose(query, refined.estimate, options.calibration, result);
  result->camera = refined.camera;
  FillMatches(query, tiles, refined, result);
}

}  // namespace cairn
