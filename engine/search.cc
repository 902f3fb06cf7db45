#include "engine/search.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "engine/find_candidates.h"
#include "engine/pose/estimate_candidate_poses.h"
#include "engine/pose/focal_search.h"
#include "engine/query/build_query_context.h"
#include "engine/refinement/match_keyframes.h"
#include "engine/rounds.h"

namespace cairn {
namespace {

using Reason = NotLocalizedReason;

// If no pose has this evidence, the query probably shows nothing of the map (docs/decisions/0062).
constexpr double kMinEvidence = 10.0;

bool CameraIsUncertain(const LocalizeQuery& query) {
  return query.focal && query.focal->log_sigma > kMaxTrustedFocalLogSigma;
}

}  // namespace

SharedMatches Search::Match(int num_keypoints, FeatureMatcher* matcher) {
  FeatureMatches found = matcher->MatchUpTo(num_keypoints, budget_.workers, stop_matching_);
  num_matches_ = std::ssize(found.correspondences);
  num_matched_keypoints_ = found.num_matched_keypoints;
  num_distances_ += found.num_distances;
  matching_cut_short_ |= found.was_stopped;
  is_complete_ &= !found.was_stopped;
  return found.num_matched_keypoints < options_.pose.min_inliers
             ? nullptr
             : std::make_shared<const std::vector<Correspondence>>(
                   std::move(found.correspondences));
}

void Search::Vote(const QueryContext& context, const SharedMatches& matches) {
  VotedPoses voted = FindCandidates({context, tiles_, matches}, options_, budget_);
  candidates_ = std::move(voted.candidates);
  num_votes_ = voted.num_votes;
  num_candidates_ = std::ssize(candidates_);
}

void Search::Estimate(const QueryContext& context, const SharedMatches& matches) {
  TriedPoses tried =
      EstimateCandidatePoses(context, matches, candidates_,
                             {options_.pose, options_.refinement.good_evidence, options_.seed},
                             budget_, std::move(hypotheses_));
  work_.Add(tried);
  Take(std::move(tried));
}

void Search::MatchKeyframesOf(const QueryContext& context, const SharedMatches& matches,
                              const RefinementOptions& refinement) {
  KeyframePoses poses = MatchKeyframes(
      {context, tiles_, matches}, {refinement, options_.matching, options_.pose, options_.seed},
      budget_, std::move(hypotheses_));
  work_.Add(poses);
  Take(std::move(poses.tried));
}

void Search::Take(TriedPoses tried) {
  hypotheses_ = std::move(tried.hypotheses);
  is_complete_ &= tried.is_complete;
}

bool Search::SeesTheMap() const {
  return options_.refinement.mode == RefinementMode::kAlways ||
         evidence_of_rounds_ >= kMinEvidence || hypotheses_.AnyHasEvidence(kMinEvidence);
}

void Search::Refine(const QueryContext& context, const SharedMatches& matches) {
  if (!NeedsRefinement(hypotheses_, options_.refinement)) {
    return;
  }
  if (SeesTheMap()) {
    MatchKeyframesOf(context, matches, options_.refinement);
    return;
  }
  if (std::exchange(was_refined_unseen_, true)) {
    return;
  }
  RefinementOptions by_matches = options_.refinement;
  by_matches.max_pose_keyframes = 0;  // The keyframes of poses by chance promise nothing.
  MatchKeyframesOf(context, matches, by_matches);
  if (SeesTheMap()) {
    RefinementOptions by_poses = options_.refinement;
    by_poses.max_keyframes = 0;
    MatchKeyframesOf(context, matches, by_poses);
  }
}

void Search::TryWithoutGravity() {
  FeatureMatcher matcher(*without_gravity_, tiles_, options_.matching);
  stop_matching_ = budget_.StopAfter(options_.matching.deadline_share);
  if (const SharedMatches matches = Match(without_gravity_->num_keypoints(), &matcher)) {
    Vote(*without_gravity_, matches);
    Estimate(*without_gravity_, matches);
    Refine(*without_gravity_, matches);
  }
}

double Search::SureEvidence() const {
  // An answer with less would be refined, or sought again without gravity.
  return std::max(options_.refinement.good_evidence, options_.refinement.min_trusted_evidence);
}

void Search::FindCameraIfUncertain(const LocalizeQuery& query, const SharedMatches& matches,
                                   bool may_refine) {
  if (camera_is_certain_) {
    return;
  }
  const FoundCamera found =
      FindCamera({context(), tiles_, matches}, query, options_, may_refine, budget_);
  work_.Add(found.work);
  is_complete_ &= found.is_complete;
  with_camera_ = WithCamera(stated_, found.camera);
  camera_is_certain_ = found.IsCertain(options_.refinement.min_trusted_evidence);
}

void Search::TryRound(int num_keypoints, const LocalizeQuery& query, StageRunner* stages) {
  SharedMatches matches;
  candidates_ = {};
  stages->Run(Stage::kMatching, [&] {
    matches = Match(num_keypoints, &*matcher_);
    return Reason::kNone;
  });
  if (matches == nullptr) {
    return;
  }
  stages->Run(Stage::kVoting, [&] {
    FindCameraIfUncertain(query, matches, /*may_refine=*/false);
    Vote(context(), matches);
    return Reason::kNone;
  });
  stages->Run(Stage::kPose, [&] {
    Estimate(context(), matches);
    return Reason::kNone;
  });
}

bool Search::AnswerEarly(const LocalizeQuery& query, StageRunner* stages) {
  int num_keypoints = FirstRound(stated_.num_keypoints());
  while (num_keypoints < stated_.num_keypoints() && stages->is_running()) {
    PoseHypotheses of_last_round = std::exchange(hypotheses_, {});
    std::optional<QueryContext> camera_of_last_round = with_camera_;
    TryRound(num_keypoints, query, stages);
    if (camera_is_certain_ && IsBeyondDoubt(hypotheses_, SureEvidence(), options_.answer)) {
      return true;
    }
    if (!hypotheses_.empty()) {
      evidence_of_rounds_ =
          std::max(evidence_of_rounds_, hypotheses_.Best(1).front()->estimate.evidence);
    }
    if (hypotheses_.empty() && budget_.DeadlinePassed()) {
      hypotheses_ = std::move(of_last_round);
      with_camera_ = std::move(camera_of_last_round);
      return false;
    }
    num_keypoints = NextRound(num_keypoints, stated_.num_keypoints(), hypotheses_, SureEvidence());
  }
  return false;
}

void Search::SearchAll(const LocalizeQuery& query, StageRunner* stages) {
  SharedMatches matches;
  stages->Run(Stage::kMatching, [&] {
    matches = Match(stated_.num_keypoints(), &*matcher_);
    return matches == nullptr ? Reason::kTooFewMatches : Reason::kNone;
  });
  stages->Run(Stage::kVoting, [&] {
    FindCameraIfUncertain(query, matches, options_.refinement.mode != RefinementMode::kNever);
    Vote(context(), matches);
    return Reason::kNone;
  });
  stages->Run(Stage::kPose, [&] {
    Estimate(context(), matches);
    return Reason::kNone;
  });
  stages->Run(Stage::kRefinement, [&] {
    Refine(context(), matches);
    if (!budget_.DeadlinePassed() &&
        DoubtsGravity(context(), hypotheses_, options_.refinement, options_.pose)) {
      without_gravity_ = WithoutGravity(context());
      TryWithoutGravity();
    }
    return hypotheses_.empty() ? Reason::kTooFewInliers : Reason::kNone;
  });
}

StageCounters Search::AddTo(StageCounters counters) const {
  counters.num_matches = num_matches_;
  counters.num_matched_keypoints = num_matched_keypoints_;
  counters.num_votes = num_votes_;
  counters.num_candidates = num_candidates_;
  counters.num_distances = num_distances_;
  counters.matching_cut_short = matching_cut_short_;
  counters.num_ransac_iterations = work_.num_ransac_iterations;
  counters.num_refined_keyframes = work_.num_refined_keyframes;
  counters.num_rematches = work_.num_rematches;
  counters.pose_cut_short = work_.pose_cut_short;
  counters.refinement_cut_short = work_.refinement_cut_short;
  return counters;
}

void Search::Run(const LocalizeQuery& query, StageRunner* stages) {
  camera_is_certain_ = !CameraIsUncertain(query);
  stages->Run(Stage::kMatching, [&] {
    matcher_.emplace(stated_, tiles_, options_.matching);
    stop_matching_ = budget_.StopAfter(options_.matching.deadline_share);
    return Reason::kNone;
  });
  // Whoever asks for refinement whatever the evidence wants all of it.
  const bool may_be_early = options_.refinement.mode == RefinementMode::kWhenWeak;
  if (!stages->is_running() || (may_be_early && AnswerEarly(query, stages))) {
    return;
  }
  // If the time ends before all keypoints have given a pose, the answer is that of the last round.
  PoseHypotheses of_last_round = std::exchange(hypotheses_, {});
  std::optional<QueryContext> camera_of_last_round = with_camera_;
  SearchAll(query, stages);
  if (hypotheses_.empty() && budget_.DeadlinePassed()) {
    hypotheses_ = std::move(of_last_round);
    with_camera_ = std::move(camera_of_last_round);
  }
}

}  // namespace cairn
