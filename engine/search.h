// The stages of a query from matching to refinement.
#ifndef CAIRN_ENGINE_SEARCH_H_
#define CAIRN_ENGINE_SEARCH_H_

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "engine/find_camera.h"
#include "engine/localizer_options.h"
#include "engine/matching/match_features.h"
#include "engine/pose/pose_hypotheses.h"
#include "engine/query/localize_query.h"
#include "engine/query/query_budget.h"
#include "engine/query/query_context.h"
#include "engine/stage_runner.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

// Searches tiles for the pose of one query, with its keypoints in rounds (engine/rounds.h): after a
// round that leaves no doubt, the search ends. Without such a round, the hypotheses are those of
// all keypoints, as if there were no rounds. Keeps references to its arguments. Use from one
// thread.
class Search {
 public:
  // There must be tiles.
  Search(const LocalizerOptions& options, const QueryBudget& budget, QueryContext context,
         std::vector<TileView> tiles)
      : options_(options), budget_(budget), stated_(std::move(context)), tiles_(std::move(tiles)) {}
  Search(const Search&) = delete;  // The matcher refers to members.
  Search& operator=(const Search&) = delete;

  const std::vector<TileView>& tiles() const { return tiles_; }

  // Runs the stages until one of them fails.
  void Run(const LocalizeQuery& query, StageRunner* stages);

  const PoseHypotheses& hypotheses() const { return hypotheses_; }
  // Returns `counters` with those of the stages.
  StageCounters AddTo(StageCounters counters) const;
  // Returns false if the deadline cut a stage short: with more time, there might be a better pose.
  bool is_complete() const { return is_complete_; }
  // The context of the query. If its focal length is uncertain, with the camera that Run has found:
  // that of the first round in which it is certain, or else that of all keypoints. Under a deadline
  // it is the camera under which the hypotheses were found.
  const QueryContext& context() const { return with_camera_ ? *with_camera_ : stated_; }
  // The context in which a hypothesis was found.
  const QueryContext& ContextOf(const PoseHypothesis& hypothesis) const {
    return without_gravity_ && !hypothesis.used_gravity ? *without_gravity_ : context();
  }

 private:
  // Matches and tries to answer in rounds, until a round leaves no doubt. Returns false if all
  // keypoints are needed or the deadline passes; the hypotheses are then those of the last round
  // that ended.
  bool AnswerEarly(const LocalizeQuery& query, StageRunner* stages);
  // Finds hypotheses from the matches of some keypoints. There must be none yet.
  void TryRound(int num_keypoints, const LocalizeQuery& query, StageRunner* stages);
  // Runs the stages on all keypoints.
  void SearchAll(const LocalizeQuery& query, StageRunner* stages);

  // The evidence of a pose that leaves no doubt.
  double SureEvidence() const;
  // Finds the best camera for the matches, unless the camera is certain.
  void FindCameraIfUncertain(const LocalizeQuery& query, const SharedMatches& matches,
                             bool may_refine);
  // Returns null if too few keypoints have a match.
  SharedMatches Match(int num_keypoints, FeatureMatcher* matcher);
  void Vote(const QueryContext& context, const SharedMatches& matches);
  void Estimate(const QueryContext& context, const SharedMatches& matches);
  // Matches keyframes again if the poses need it. If nothing says that the query sees the map, then
  // those that have the most matches, once a query, and those of the poses only if that changes.
  void Refine(const QueryContext& context, const SharedMatches& matches);
  void MatchKeyframesOf(const QueryContext& context, const SharedMatches& matches,
                        const RefinementOptions& refinement);
  void Take(TriedPoses tried);
  // Returns true if a pose, of this or an earlier round, has more evidence than most queries of
  // elsewhere reach, or if the options want refinement whatever the evidence.
  bool SeesTheMap() const;
  // Runs the stages from matching on again without gravity. Keeps the hypotheses found so far.
  void TryWithoutGravity();

  const LocalizerOptions& options_;
  const QueryBudget& budget_;
  const QueryContext stated_;
  const std::vector<TileView> tiles_;
  // Of the last run of the stages.
  int64_t num_matches_ = 0, num_matched_keypoints_ = 0, num_votes_ = 0, num_candidates_ = 0;
  // Of all runs.
  int64_t num_distances_ = 0;
  bool matching_cut_short_ = false;
  PoseWork work_;
  std::optional<FeatureMatcher> matcher_;
  StopFunction stop_matching_;
  bool camera_is_certain_ = true;
  bool is_complete_ = true;
  std::vector<PoseCandidate> candidates_;
  PoseHypotheses hypotheses_;
  bool was_refined_unseen_ = false;
  double evidence_of_rounds_ = 0.0;  // The largest of any round that left doubt.
  std::optional<QueryContext> with_camera_;
  std::optional<QueryContext> without_gravity_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_SEARCH_H_
