#include "engine/answer/refine_winner.h"

#include <algorithm>
#include <memory>
#include <tuple>
#include <utility>

#include "engine/pose/estimate_pose.h"
#include "engine/pose/focal_refinement.h"
#include "engine/pose/focal_search.h"

namespace cairn {
namespace {

// Merges the matches of several searches. Sorts by keypoint and removes repeated matches, keeping
// the nearest.
void MergeMatches(std::vector<Correspondence>* matches) {
  const auto key = [](const Correspondence& match) {
    return std::tuple(match.keypoint_idx, match.tile_idx, match.landmark_idx);
  };
  std::sort(matches->begin(), matches->end(),
            [&](const Correspondence& a, const Correspondence& b) {
              return std::pair(key(a), a.sq_distance) < std::pair(key(b), b.sq_distance);
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
                            const PoseHypotheses& hypotheses, const PoseHypothesis& winner,
                            const PoseOptions& options) {
  PoseHypothesis refined = RefinedOnAllMatches(query, hypotheses, winner, options);
  refined.estimate =
      RefineOnLikelyInliers(query, *refined.correspondences, std::move(refined.estimate), options);
  return RefinedWithCamera(query, stated, std::move(refined), options);
}

}  // namespace cairn
