#include "engine/find_camera.h"

#include <algorithm>
#include <map>

#include "engine/find_candidates.h"
#include "engine/pose/estimate_candidate_poses.h"
#include "engine/pose/focal_refinement.h"
#include "engine/pose/focal_search.h"
#include "engine/query/build_query_context.h"
#include "engine/refinement/match_keyframes.h"

namespace cairn {
namespace {

struct BestGuess {
  Camera camera;
  double evidence = 0.0;
};

// Refines the best poses of a guess together with the camera. Returns the largest evidence, and
// keeps the camera in `best` if it is the best of all guesses.
double JudgeGuess(const QueryContext& query, const PoseHypotheses& hypotheses,
                  const CameraPrior& prior, const PoseOptions& options, BestGuess* best) {
  constexpr int kNumRefined = 2;
  double evidence = 0.0;
  for (const PoseHypothesis* pose : hypotheses.Best(kNumRefined)) {
    if (pose->estimate.evidence < kMinShareOfBest * best->evidence) {
      continue;
    }
    const auto refined =
        RefineWithCamera(query, *pose->correspondences, pose->estimate, prior, options);
    if (!refined) {
      continue;
    }
    evidence = std::max(evidence, refined->estimate.evidence);
    if (refined->estimate.evidence > best->evidence) {
      *best = {refined->camera.camera, refined->estimate.evidence};
    }
  }
  return evidence;
}

}  // namespace

QueryContext FindCamera(const QueryContext& stated, const LocalizeQuery& query,
                        const std::vector<TileView>& tiles, const SharedMatches& matches,
                        const LocalizerOptions& options, const QueryBudget& budget,
                        StageCounters* counters) {
  const CameraPrior prior = CameraPriorOf(query);
  BestGuess best{prior.camera};
  std::map<double, PoseHypotheses> voted;  // By factor.
  PoseHypotheses hypotheses;               // Hands on the consensus of the best pose so far.
  // Returns the evidence of the guess.
  const auto vote = [&](double factor, const QueryContext& scaled) {
    EstimateCandidatePoses(scaled, matches,
                           FindCandidates(scaled, tiles, *matches, options, budget, counters),
                           options.pose, options.refinement.good_evidence, options.seed, budget,
                           &hypotheses, counters);
    voted[factor] = hypotheses;
    const double evidence = JudgeGuess(scaled, hypotheses, prior, options.pose, &best);
    hypotheses.DropPoses();
    return evidence;
  };
  const auto match_keyframes = [&](double factor, const QueryContext& scaled) {
    PoseHypotheses& of_guess = voted[factor];
    MatchKeyframes(scaled, tiles, *matches, options.refinement, options.matching, options.pose,
                   options.seed, budget, &of_guess, counters);
    return JudgeGuess(scaled, of_guess, prior, options.pose, &best);
  };
  const auto try_guesses = [&](const auto& evidence_of) {
    FocalSearch search(prior.focal, options.refinement.good_evidence);
    while (const auto factor = budget.DeadlinePassed() ? std::nullopt : search.Next()) {
      search.Report(
          evidence_of(*factor, WithCamera(stated, WithFocalScaled(prior.camera, *factor))));
    }
  };
  try_guesses(vote);
  if (options.refinement.mode != RefinementMode::kNever &&
      best.evidence < options.refinement.good_evidence) {
    try_guesses(match_keyframes);
  }
  return WithCamera(stated, best.camera);
}

}  // namespace cairn
