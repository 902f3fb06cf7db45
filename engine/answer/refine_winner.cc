#include "engine/answer/refine_winner.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/answer/refine_by_shapes.h"
#include "engine/pose/estimate_pose.h"
#include "engine/pose/focal_refinement.h"
#include "engine/pose/focal_search.h"
#include "engine/refinement/guided_matches.h"

namespace cairn {
namespace {

// Merges the matches of several searches. Sorts by keypoint and removes repeated matches, keeping
// the nearest of those that were found without a pose.
void MergeMatches(std::vector<Correspondence>* matches) {
  const auto key = [](const Correspondence& match) {
    return std::tuple(match.keypoint_idx, match.tile_idx, match.landmark_idx);
  };
  std::sort(matches->begin(), matches->end(),
            [&](const Correspondence& a, const Correspondence& b) {
              return std::tuple(key(a), a.search_area_sq_px, a.sq_distance) <
                     std::tuple(key(b), b.search_area_sq_px, b.sq_distance);
            });
  matches->erase(std::unique(matches->begin(), matches->end(),
                             [&](const Correspondence& a, const Correspondence& b) {
                               return key(a) == key(b);
                             }),
                 matches->end());
}

// Refines the winner on the matches of all poses that might have won, not only on those in which
// the winner was found.
PoseHypothesis RefinedOnAllMatches(const QueryContext& query, const PoseHypotheses& hypotheses,
                                   const PoseHypothesis& winner, const PoseOptions& options) {
  const auto all = std::make_shared<std::vector<Correspondence>>();
  std::vector<const std::vector<Correspondence>*> taken;
  const double min_evidence = kMinShareOfBest * hypotheses.Best(1).front()->estimate.evidence;
  for (const PoseHypothesis& hypothesis : hypotheses.all()) {
    const std::vector<Correspondence>* matches = hypothesis.correspondences.get();
    if (hypothesis.estimate.evidence >= min_evidence &&
        std::find(taken.begin(), taken.end(), matches) == taken.end()) {
      taken.push_back(matches);
      all->insert(all->end(), matches->begin(), matches->end());
    }
  }
  if (taken.size() < 2) {
    return winner;
  }
  MergeMatches(all.get());
  auto refined = RefineEstimate(query, *all, winner.estimate, options);
  return refined ? PoseHypothesis{std::move(*refined), all, winner.used_gravity, {}} : winner;
}

// Returns the expected number of right inliers.
double NumRight(const PoseEstimate& estimate) {
  return std::accumulate(estimate.right_probabilities.begin(), estimate.right_probabilities.end(),
                         0.0);
}

// Refines the pose on its own matches and those that it predicts.
PoseHypothesis RefinedOnGuidedMatches(const QueryContext& query, const std::vector<TileView>& tiles,
                                      PoseHypothesis winner, const PoseOptions& options) {
  const auto all = std::make_shared<std::vector<Correspondence>>(
      GuidedMatches(query, tiles, winner.estimate, options));
  all->insert(all->end(), winner.correspondences->begin(), winner.correspondences->end());
  MergeMatches(all.get());
  auto refined = RefineEstimate(query, *all, winner.estimate, options);
  if (refined && NumRight(*refined) > NumRight(winner.estimate)) {
    winner.estimate = std::move(*refined);
    winner.correspondences = all;
  }
  return winner;
}

// Refines the pose together with its camera. The covariance of the pose then includes the camera's
// uncertainty.
PoseHypothesis RefinedWithCamera(const QueryContext& query, const LocalizeQuery& stated,
                                 PoseHypothesis winner, const PoseOptions& options) {
  if (query.is_rig()) {
    return winner;
  }
  const CameraPrior prior = CameraPriorOf(stated);
  AnsweredCamera refined =
      RefineAnswer(query, *winner.correspondences, std::move(winner.estimate), prior,
                   /*keep_if_possible=*/!stated.focal, options);
  winner.estimate = std::move(refined.estimate);
  if (refined.camera) {
    winner.estimate.log_camera_share = LogCameraShare(prior, *refined.camera);
    winner.camera = MakeCameraEstimate(prior, *refined.camera);
  }
  return winner;
}

}  // namespace

PoseHypothesis RefineWinner(const QueryContext& query, const LocalizeQuery& stated,
                            const std::vector<TileView>& tiles, const PoseHypotheses& hypotheses,
                            const PoseHypothesis& winner, const PoseOptions& options,
                            double sure_evidence) {
  PoseHypothesis refined = RefinedOnAllMatches(query, hypotheses, winner, options);
  // Matches that the pose predicts add precision. They crowd the image, which must not take from
  // the evidence that was found without them.
  const double found_evidence = refined.estimate.evidence;
  const bool is_sure = found_evidence >= sure_evidence;
  if (is_sure) {
    refined = RefinedOnGuidedMatches(query, tiles, std::move(refined), options);
  }
  refined.estimate =
      RefineOnLikelyInliers(query, *refined.correspondences, std::move(refined.estimate), options);
  // The floor comes last: the camera is judged by two evidences of the same matches.
  refined = RefinedWithCamera(query, stated, std::move(refined), options);
  refined = RefineByShapes(query, stated, tiles, std::move(refined), options);
  if (is_sure) {
    refined.estimate.evidence = std::max(refined.estimate.evidence, found_evidence);
  }
  return refined;
}

}  // namespace cairn
