#include "engine/refinement/match_keyframes.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>

#include "engine/matching/match_features.h"
#include "engine/pose/estimate_pose.h"
#include "engine/refinement/rank_keyframes.h"

namespace cairn {
namespace {

// Descriptors match a keyframe within this quantile of the same-landmark distances: the largest
// that MatchingOptions::distance_quantile allows.
constexpr double kRelaxedDistanceQuantile = 0.95;

std::vector<Correspondence> InliersOf(const PoseHypothesis& pose) {
  std::vector<Correspondence> inliers;
  for (const int index : pose.estimate.inliers) {
    inliers.push_back((*pose.correspondences)[index]);
  }
  return inliers;
}

// Returns the neighborhoods to match, most promising first. A keyframe that an earlier neighborhood
// holds has no neighborhood of its own: the query would mostly be matched against the same
// landmarks again. On a small map, where every keyframe is a neighbor of most others, that saves
// most of the work.
std::vector<std::vector<KeyframeRef>> NeighborhoodsToMatch(const MatchedQuery& matched,
                                                           const PoseHypotheses& hypotheses,
                                                           const RefinementOptions& options) {
  std::vector<std::vector<KeyframeRef>> neighborhoods;
  const auto is_held = [&](const KeyframeRef& keyframe) {
    return std::any_of(neighborhoods.begin(), neighborhoods.end(), [&](const auto& held) {
      return std::find(held.begin(), held.end(), keyframe) != held.end();
    });
  };
  const auto add_first = [&](const std::vector<Correspondence>& correspondences, int count) {
    RefinementOptions ranking = options;
    ranking.max_keyframes = count;
    for (const RankedKeyframe& ranked :
         RankKeyframes(matched.query, matched.tiles, correspondences, ranking)) {
      if (!is_held(ranked.keyframe)) {
        neighborhoods.push_back(
            KeyframeNeighborhood(matched.tiles, ranked.keyframe, options.neighbors_per_keyframe));
      }
    }
  };
  for (const PoseHypothesis* pose : hypotheses.Best(options.max_pose_keyframes)) {
    add_first(InliersOf(*pose), 1);
  }
  add_first(*matched.matches, options.max_keyframes);
  return neighborhoods;
}

}  // namespace

bool NeedsRefinement(const PoseHypotheses& hypotheses, const RefinementOptions& options) {
  switch (options.mode) {
    case RefinementMode::kNever:
      return false;
    case RefinementMode::kAlways:
      return true;
    case RefinementMode::kWhenWeak:
      break;
  }
  return !hypotheses.AnyHasEvidence(options.good_evidence);
}

KeyframePoses MatchKeyframes(const MatchedQuery& matched, const KeyframeMatching& options,
                             const QueryBudget& budget, PoseHypotheses hypotheses) {
  const QueryContext& query = matched.query;
  const std::vector<std::vector<KeyframeRef>> neighborhoods =
      NeighborhoodsToMatch(matched, hypotheses, options.refinement);
  const KeyframeMatcher matcher(query, matched.tiles, kRelaxedDistanceQuantile, options.matching);
  std::vector<int64_t> num_rematches(neighborhoods.size(), 0);
  const auto attempt = [&](int i, double min_consensus) -> PoseAttempt {
    const auto rematches =
        std::make_shared<const std::vector<Correspondence>>(matcher.Match(neighborhoods[i]));
    num_rematches[i] = static_cast<int64_t>(rematches->size());
    std::vector<int> all(rematches->size());
    std::iota(all.begin(), all.end(), 0);
    return {rematches,
            EstimatePose(query, *rematches, all, options.pose, options.seed, min_consensus)};
  };
  const auto num_keyframes = static_cast<int>(neighborhoods.size());
  const AttemptCount count =
      hypotheses.TryInRounds(num_keyframes, query.down_in_cam.has_value(), budget, attempt);
  return {{std::move(hypotheses), count, count.num_made == num_keyframes},
          std::accumulate(num_rematches.begin(), num_rematches.end(), int64_t{0})};
}

bool DoubtsGravity(const QueryContext& query, const PoseHypotheses& hypotheses,
                   const RefinementOptions& options, const PoseOptions& pose) {
  if (!query.down_in_cam || options.mode == RefinementMode::kNever ||
      pose.solver == MinimalSolver::kGravityTwoPoint) {
    return false;
  }
  if (!hypotheses.AnyHasEvidence(options.min_trusted_evidence)) {
    return true;
  }
  const PoseEstimate& best = hypotheses.Best(1).front()->estimate;
  const Eigen::Vector3d down_in_cam = best.cam_from_anchor.rotation * -Eigen::Vector3d::UnitZ();
  const double tilt_rad = std::acos(std::clamp(down_in_cam.dot(*query.down_in_cam), -1.0, 1.0));
  return best.evidence < options.good_evidence &&
         tilt_rad > options.max_gravity_error_sigmas * pose.gravity_sigma_rad;
}

}  // namespace cairn
