#include "engine/answer/answer.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/check.h"
#include "core/radius68.h"
#include "engine/answer/view_recall.h"
#include "engine/pose/evidence.h"
#include "engine/query/build_query_context.h"
#include "engine/refinement/bernoulli_divergence.h"
#include "engine/tiles/pose_share.h"
#include "storage/map/session_accuracy.h"

namespace cairn {
namespace {

// An answer whose camera was estimated needs this confidence. The least score of an answer means as
// much for a position that is certain (AnswerOptions::min_score). A focal length that is estimated
// trades off against the distance, so the position may be uncertain although the score is high.
constexpr double kMinConfidenceOfEstimatedCamera = 0.5;

// A hypothesis with its score.
struct Contender {
  const PoseHypothesis* hypothesis = nullptr;
  double score = 0.0;
};

Contender MakeContender(const QueryContext& query, const PoseHypothesis& hypothesis) {
  const Eigen::Vector3d center_in_anchor =
      hypothesis.estimate.cam_from_anchor.Inverse().translation;
  return {&hypothesis, hypothesis.estimate.evidence +
                           LogPoseShare(query.region, center_in_anchor, hypothesis.estimate)};
}

// Returns the probability that each keypoint's match is right if the pose is right.
std::map<int, double> RightByKeypoint(const PoseHypothesis& hypothesis) {
  std::map<int, double> right;
  const PoseEstimate& estimate = hypothesis.estimate;
  for (size_t i = 0; i < estimate.inliers.size(); ++i) {
    right[(*hypothesis.correspondences)[estimate.inliers[i]].keypoint_idx] =
        estimate.right_probabilities[i];
  }
  return right;
}

// Returns true if the likely inliers decide for `a` over `b`, two poses that are far apart.
// Keypoints that both poses explain, such as those on a facade that repeats, do not count. Two
// conditions must hold. First, `b` has at most kDecisiveInlierShare of the likely inliers of `a`.
// Second, if both poses were equally good, the keypoints that only one of them explains would be
// split as unevenly with a probability of at most exp(-kDecisiveEvidence). The score alone cannot
// decide, because it saturates at dense matches. The share is needed where facades repeat in every
// detail: the wrong pose may then have a tenth more inliers than the right one, because the map saw
// the wrong facade better.
bool Outdoes(const PoseHypothesis& a, const PoseHypothesis& b) {
  constexpr double kDecisiveInlierShare = 0.85;
  constexpr double kDecisiveEvidence = 6.9;  // One in a thousand.
  const std::map<int, double> of_a = RightByKeypoint(a), of_b = RightByKeypoint(b);
  double sum_a = 0.0, sum_b = 0.0, num_for = 0.0, num_against = 0.0;
  for (const auto& [keypoint_idx, right] : of_a) {
    const auto other = of_b.find(keypoint_idx);
    sum_a += right;
    num_for += std::max(0.0, right - (other == of_b.end() ? 0.0 : other->second));
  }
  for (const auto& [keypoint_idx, right] : of_b) {
    const auto other = of_a.find(keypoint_idx);
    sum_b += right;
    num_against += std::max(0.0, right - (other == of_a.end() ? 0.0 : other->second));
  }
  const double num_all = num_for + num_against;
  return num_for > num_against && sum_b <= kDecisiveInlierShare * sum_a &&
         num_all * BernoulliDivergence(num_for / num_all, 0.5) >= kDecisiveEvidence;
}

// Returns true if `rival` explains the image about as well as `best` from somewhere else.
bool Rivals(const Contender& rival, const Contender& best, const AnswerOptions& options) {
  return rival.score >= options.ambiguous_score_ratio * best.score &&
         AreFarApart(best.hypothesis->estimate.cam_from_anchor,
                     rival.hypothesis->estimate.cam_from_anchor, options);
}

// Returns the winner among contenders in descending order of score; null if the answer is
// ambiguous.
const PoseHypothesis* FindWinner(const std::vector<Contender>& by_score,
                                 const AnswerOptions& options) {
  Contender best = by_score.front();
  for (const Contender& rival : by_score) {
    if (Rivals(rival, best, options) && Outdoes(*rival.hypothesis, *best.hypothesis)) {
      best = rival;
    }
  }
  const bool is_ambiguous =
      std::any_of(by_score.begin(), by_score.end(), [&](const Contender& rival) {
        return Rivals(rival, best, options) && !Outdoes(*best.hypothesis, *rival.hypothesis);
      });
  return is_ambiguous ? nullptr : best.hypothesis;
}

void FillMatches(const QueryContext& query, const std::vector<TileView>& tiles,
                 const PoseHypothesis& hypothesis, LocalizeResult* result) {
  std::vector<int> first_keypoint(query.num_cameras(), 0);
  for (int i = query.is_rig() ? query.num_keypoints() - 1 : -1; i >= 0; --i) {
    first_keypoint[query.CameraIdxOf(i)] = i;
  }
  for (size_t i = 0; i < hypothesis.estimate.inliers.size(); ++i) {
    const Correspondence& match = (*hypothesis.correspondences)[hypothesis.estimate.inliers[i]];
    const Keypoint& keypoint = query.keypoints[match.keypoint_idx];
    LocalizeMatch out;
    out.camera_idx = query.CameraIdxOf(match.keypoint_idx);
    out.keypoint_idx = match.keypoint_idx - first_keypoint[out.camera_idx];
    out.pixel = {keypoint.x_px, keypoint.y_px};
    out.landmark_id = tiles[match.tile_idx].tile->landmarks().landmark_ids[match.landmark_idx];
    out.tile_idx = match.tile_idx;
    out.x_in_anchor = match.x_in_anchor;
    out.sigma_m = match.sigma_m;
    const auto traits = TraitsOf(query, match, hypothesis.estimate.cam_from_anchor);
    if (!traits) {
      continue;  // Rounding put the landmark just outside the camera's field of view.
    }
    out.traits = *traits;
    out.right_probability = hypothesis.estimate.right_probabilities[i];
    result->matches.push_back(out);
  }
  std::sort(result->matches.begin(), result->matches.end(),
            [](const LocalizeMatch& a, const LocalizeMatch& b) {
              return std::pair(a.camera_idx, a.keypoint_idx) <
                     std::pair(b.camera_idx, b.keypoint_idx);
            });
}

// Returns the accuracy of the map at the inliers of the winner: the root mean square over them.
SessionAccuracy AccuracyOfMap(const std::vector<TileView>& tiles, const PoseHypothesis& winner,
                              const ScoreCalibration& calibration) {
  const SessionAccuracy unknown = {.on_earth_m = calibration.map_accuracy_m};
  std::vector<SessionAccuracy> accuracies;
  for (const int inlier : winner.estimate.inliers) {
    const size_t tile_idx = (*winner.correspondences)[inlier].tile_idx;
    accuracies.push_back(tiles[tile_idx].tile->accuracy().value_or(unknown));
  }
  return accuracies.empty() ? unknown : RootMeanSquare(accuracies);
}

void FillPose(const QueryContext& query, const std::vector<TileView>& tiles,
              const Contender& winner, const ScoreCalibration& calibration, double view_recall,
              LocalizeResult* result) {
  const PoseEstimate& estimate = winner.hypothesis->estimate;
  result->localized = true;
  result->anchor = query.region.origin;
  result->cam_from_anchor = estimate.cam_from_anchor;
  result->cam_from_ecef = estimate.cam_from_anchor * query.region.ecef_from_anchor.Inverse();
  result->position = GeodeticFromEcef(result->cam_from_ecef.Inverse().translation);
  const SessionAccuracy map = AccuracyOfMap(tiles, *winner.hypothesis, calibration);
  result->covariance = calibration.Calibrated(estimate.covariance, map.in_map_m);
  result->rotation_accuracy_rad = Radius68(result->covariance.topLeftCorner<3, 3>());
  result->position_accuracy_m = Radius68(result->covariance.bottomRightCorner<3, 3>());
  result->map_accuracy_m = map.on_earth_m;
  result->map_accuracy_rad = map.on_earth_rad;
  result->score = winner.score;
  result->confidence = RecallConfidence(view_recall) *
                       calibration.Confidence(winner.score, result->position_accuracy_m);
  result->false_alarm_rate = calibration.FalseAlarmRate(winner.score);
  result->prior_disagrees =
      DisagreesWithPrior(query.region, estimate.cam_from_anchor.Inverse().translation);
  result->counters.used_gravity = winner.hypothesis->used_gravity;
}

// Returns why a pose with too low a score is not an answer: kPriorMismatch if the pose would be one
// without the prior.
NotLocalizedReason ReasonOfWeakness(const QueryContext& query, const Contender& best,
                                    const AnswerOptions& options) {
  const bool the_prior_decides =
      DisagreesWithPrior(query.region,
                         best.hypothesis->estimate.cam_from_anchor.Inverse().translation) &&
      best.hypothesis->estimate.evidence +
              LogPoseShare(query.region, PriorCenter(query.region), best.hypothesis->estimate) >=
          options.min_score;
  return the_prior_decides ? NotLocalizedReason::kPriorMismatch
                           : NotLocalizedReason::kTooFewInliers;
}

}  // namespace

bool AreFarApart(const Rigid3d& a, const Rigid3d& b, const AnswerOptions& options) {
  return (a.Inverse().translation - b.Inverse().translation).norm() >
             options.ambiguous_distance_m ||
         RotationAngleRad(a.rotation, b.rotation) > options.ambiguous_rotation_rad;
}

LocalizeResult ConcludeAnswer(const QueryContext& query, const std::vector<TileView>& tiles,
                              const std::vector<PoseHypothesis>& hypotheses,
                              const AnswerOptions& options,
                              const std::function<PoseHypothesis(const PoseHypothesis&)>& refine,
                              LocalizeResult result) {
  const auto without_pose = [&](NotLocalizedReason reason) {
    result.reason = reason;
    return std::move(result);
  };
  CAIRN_CHECK(!hypotheses.empty(), "there are no hypotheses");
  std::vector<Contender> by_score;
  for (const PoseHypothesis& hypothesis : hypotheses) {
    by_score.push_back(MakeContender(query, hypothesis));
  }
  std::stable_sort(by_score.begin(), by_score.end(),
                   [](const Contender& a, const Contender& b) { return a.score > b.score; });
  const PoseHypothesis* winner = FindWinner(by_score, options);
  if (winner == nullptr) {
    return without_pose(by_score.front().score >= options.min_score
                            ? NotLocalizedReason::kAmbiguous
                            : ReasonOfWeakness(query, by_score.front(), options));
  }
  const PoseHypothesis refined = refine(*winner);
  const Contender answer = MakeContender(query, refined);
  if (answer.score < options.min_score) {
    return without_pose(ReasonOfWeakness(query, answer, options));
  }
  LocalizeResult filled = result;
  filled.reason = NotLocalizedReason::kNone;
  FillPose(
      query, tiles, answer, options.calibration,
      ViewRecall(query, tiles, refined.camera ? refined.camera->camera : query.camera, refined),
      &filled);
  if (refined.camera && filled.confidence < kMinConfidenceOfEstimatedCamera) {
    return without_pose(NotLocalizedReason::kTooFewInliers);
  }
  filled.camera = refined.camera;
  FillMatches(refined.camera ? WithCamera(query, refined.camera->camera) : query, tiles, refined,
              &filled);
  return filled;
}

}  // namespace cairn
