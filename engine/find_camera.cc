#include "engine/find_camera.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/find_candidates.h"
#include "engine/pose/estimate_candidate_poses.h"
#include "engine/pose/focal_refinement.h"
#include "engine/pose/focal_search.h"
#include "engine/query/build_query_context.h"

namespace cairn {
namespace {

// Returns the cameras with which the best poses of a guess were refined. `best_evidence` is the
// largest evidence of any guess so far.
std::vector<FoundCamera> CamerasOfGuess(const QueryContext& query, const PoseHypotheses& hypotheses,
                                        const CameraPrior& prior, const PoseOptions& options,
                                        double best_evidence) {
  constexpr int kNumRefined = 2;
  std::vector<FoundCamera> found;
  for (const PoseHypothesis* pose : hypotheses.Best(kNumRefined)) {
    if (pose->estimate.evidence < kMinShareOfBest * best_evidence) {
      continue;
    }
    const auto refined =
        RefineWithCamera(query, *pose->correspondences, pose->estimate, prior, options);
    if (refined) {
      best_evidence = std::max(best_evidence, refined->estimate.evidence);
      found.push_back(
          {refined->camera.camera, refined->camera.focal_log_sigma, refined->estimate.evidence});
    }
  }
  return found;
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

void PoseWork::Add(const PoseWork& other) {
  num_ransac_iterations += other.num_ransac_iterations;
  num_refined_keyframes += other.num_refined_keyframes;
  num_rematches += other.num_rematches;
  pose_cut_short |= other.pose_cut_short;
  refinement_cut_short |= other.refinement_cut_short;
}

void PoseWork::Add(const TriedPoses& poses) {
  num_ransac_iterations += poses.count.num_ransac_iterations;
  pose_cut_short |= !poses.is_complete;
}

void PoseWork::Add(const KeyframePoses& poses) {
  num_ransac_iterations += poses.tried.count.num_ransac_iterations;
  num_refined_keyframes += poses.tried.count.num_made;
  num_rematches += poses.num_rematches;
  refinement_cut_short |= !poses.tried.is_complete;
}

FoundCamera FindCamera(const MatchedQuery& matched, const LocalizeQuery& stated,
                       const LocalizerOptions& options, bool may_refine,
                       const QueryBudget& budget) {
  const CameraPrior prior = CameraPriorOf(stated);
  const std::vector<double> guesses = FocalGuesses(prior.focal);
  std::vector<PoseHypotheses> of_guess(guesses.size());
  double best_evidence = 0.0;
  std::vector<FoundCamera> found;
  PoseWork work;
  bool is_complete = true;
  // `find_poses` returns the hypotheses of a guess, given those that it has.
  const auto try_guesses = [&](const auto& find_poses) {
    for (size_t i = 0; i < guesses.size(); ++i) {
      if (budget.DeadlinePassed()) {
        is_complete = false;
        break;
      }
      const QueryContext guess =
          WithCamera(matched.query, WithFocalScaled(prior.camera, guesses[i]));
      TriedPoses tried =
          find_poses(MatchedQuery{guess, matched.tiles, matched.matches}, std::move(of_guess[i]));
      is_complete &= tried.is_complete;
      of_guess[i] = std::move(tried.hypotheses);
      for (FoundCamera& camera :
           CamerasOfGuess(guess, of_guess[i], prior, options.pose, best_evidence)) {
        best_evidence = std::max(best_evidence, camera.evidence);
        found.push_back(std::move(camera));
      }
    }
  };
  PoseHypotheses voted;  // Hands on the consensus of the best pose so far.
  try_guesses([&](const MatchedQuery& guess, PoseHypotheses /*none*/) {
    TriedPoses tried = EstimateCandidatePoses(
        guess.query, guess.matches, FindCandidates(guess, options, budget).candidates,
        {options.pose, options.refinement.good_evidence, options.seed}, budget, std::move(voted));
    work.Add(tried);
    voted = tried.hypotheses;
    voted.DropPoses();
    return tried;
  });
  if (may_refine && best_evidence < options.refinement.good_evidence) {
    try_guesses([&](const MatchedQuery& guess, PoseHypotheses hypotheses) {
      KeyframePoses poses =
          MatchKeyframes(guess, {options.refinement, options.matching, options.pose, options.seed},
                         budget, std::move(hypotheses));
      work.Add(poses);
      return std::move(poses.tried);
    });
  }
  FoundCamera best = BestOf(found, prior);
  best.is_complete = is_complete;
  best.work = work;
  return best;
}

}  // namespace cairn
