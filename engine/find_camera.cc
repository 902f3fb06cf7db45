#include "engine/find_camera.h"

#include <algorithm>
#include <cmath>

#include "engine/find_candidates.h"
#include "engine/pose/estimate_candidate_poses.h"
#include "engine/pose/focal_refinement.h"
#include "engine/pose/focal_search.h"
#include "engine/query/build_query_context.h"
#include "engine/refinement/match_keyframes.h"

namespace cairn {
namespace {

// Refines the best poses of a guess together with the camera. Adds the cameras to `found`.
// `best_evidence` is the largest evidence of any guess so far.
void JudgeGuess(const QueryContext& query, const PoseHypotheses& hypotheses,
                const CameraPrior& prior, const PoseOptions& options, double* best_evidence,
                std::vector<FoundCamera>* found) {
  constexpr int kNumRefined = 2;
  for (const PoseHypothesis* pose : hypotheses.Best(kNumRefined)) {
    if (pose->estimate.evidence < kMinShareOfBest * *best_evidence) {
      continue;
    }
    const auto refined =
        RefineWithCamera(query, *pose->correspondences, pose->estimate, prior, options);
    if (refined) {
      *best_evidence = std::max(*best_evidence, refined->estimate.evidence);
      found->push_back(
          {refined->camera.camera, refined->camera.focal_log_sigma, refined->estimate.evidence});
    }
  }
}

bool FocalLengthsDiffer(const FoundCamera& a, const FoundCamera& b) {
  constexpr double kMaxSigmas = 3.0;
  return std::abs(std::log(a.camera.focal_px() / b.camera.focal_px())) >
         kMaxSigmas * std::hypot(a.focal_log_sigma, b.focal_log_sigma);
}

// Returns the camera with the most evidence, or the prior's if none has any.
FoundCamera BestOf(const std::vector<FoundCamera>& found, const CameraPrior& prior) {
  FoundCamera best{prior.camera, prior.focal.log_sigma};
  for (const FoundCamera& camera : found) {
    if (camera.evidence > best.evidence) {
      best = camera;
    }
  }
  for (const FoundCamera& camera : found) {
    if (FocalLengthsDiffer(camera, best)) {
      best.rival_evidence = std::max(best.rival_evidence, camera.evidence);
    }
  }
  return best;
}

}  // namespace

bool FoundCamera::IsCertain(double min_evidence) const {
  return evidence >= min_evidence && rival_evidence < kMinShareOfBest * evidence &&
         focal_log_sigma <= kMaxTrustedFocalLogSigma;
}

FoundCamera FindCamera(const QueryContext& query, const LocalizeQuery& stated,
                       const std::vector<TileView>& tiles, const SharedMatches& matches,
                       const LocalizerOptions& options, bool may_refine, const QueryBudget& budget,
                       StageCounters* counters) {
  const CameraPrior prior = CameraPriorOf(stated);
  const std::vector<double> guesses = FocalGuesses(prior.focal);
  std::vector<PoseHypotheses> of_guess(guesses.size());
  double best_evidence = 0.0;
  std::vector<FoundCamera> found;
  bool is_complete = true;
  const auto try_guesses = [&](const auto& find_poses) {
    for (size_t i = 0; i < guesses.size(); ++i) {
      if (budget.DeadlinePassed()) {
        is_complete = false;
        break;
      }
      const QueryContext guess = WithCamera(query, WithFocalScaled(prior.camera, guesses[i]));
      is_complete &= find_poses(guess, &of_guess[i]);
      JudgeGuess(guess, of_guess[i], prior, options.pose, &best_evidence, &found);
    }
  };
  PoseHypotheses voted;  // Hands on the consensus of the best pose so far.
  try_guesses([&](const QueryContext& guess, PoseHypotheses* hypotheses) {
    const bool tried_all = EstimateCandidatePoses(
        guess, matches, FindCandidates(guess, tiles, *matches, options, budget, counters),
        options.pose, options.refinement.good_evidence, options.seed, budget, &voted, counters);
    *hypotheses = voted;
    voted.DropPoses();
    return tried_all;
  });
  if (may_refine && best_evidence < options.refinement.good_evidence) {
    try_guesses([&](const QueryContext& guess, PoseHypotheses* hypotheses) {
      return MatchKeyframes(guess, tiles, *matches,
                            {options.refinement, options.matching, options.pose, options.seed},
                            budget, hypotheses, counters);
    });
  }
  FoundCamera best = BestOf(found, prior);
  best.is_complete = is_complete;
  return best;
}

}  // namespace cairn
