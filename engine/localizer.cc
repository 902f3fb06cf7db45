#include "engine/localizer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "core/shared_workers.h"
#include "engine/answer/answer.h"
#include "engine/focal/focal_refinement.h"
#include "engine/focal/focal_search.h"
#include "engine/matching/match_features.h"
#include "engine/pose/estimate_pose.h"
#include "engine/prior/search_region.h"
#include "engine/query/build_query_context.h"
#include "engine/refinement/keyframe_candidates.h"
#include "engine/refinement/rank_keyframes.h"
#include "engine/tiles/fetch_tiles.h"
#include "engine/tiles/tile_finisher.h"
#include "engine/voting/pose_voting.h"
#include "storage/codebook/descriptor_codec.h"

namespace cairn {

struct Localizer::Impl {
  std::shared_ptr<const MapStore> store;
  std::shared_ptr<TileCache> cache;
  LocalizerOptions options;
  SharedWorkers workers;
  TileFinisher finisher{store.get(), cache.get(), &options.tiles, &options.matching.index,
                        &workers};
};

namespace {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// A pose that was searched for, and in what. No correspondences: there was no time left.
struct Attempt {
  std::shared_ptr<const std::vector<Correspondence>> correspondences;
  std::optional<PoseEstimate> estimate;
};

// A pose with a smaller share of what speaks for the best one could neither win nor make the answer
// ambiguous.
constexpr double kMinShareOfBest = 0.5;

// There might have been more with more time.
bool FoundTooLittle(NotLocalizedReason reason) {
  return reason == NotLocalizedReason::kTooFewMatches ||
         reason == NotLocalizedReason::kTooFewInliers;
}

// Orders the matches of several searches by keypoint and leaves of each only the nearest.
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

// One query on its way through the stages. A stage that finds that there cannot be an answer
// returns the reason, and the ones after it do not run.
class QueryRun {
 public:
  QueryRun(const MapStore& store, TileCache* cache, const LocalizerOptions& options,
           SharedWorkers* workers, const LocalizeQuery& query)
      : store_(store), cache_(cache), options_(options), workers_(workers), query_(query) {}

  LocalizeResult Run();
  const SearchRegion& region() const { return context_.region; }

 private:
  using StageMethod = NotLocalizedReason (QueryRun::*)();

  NotLocalizedReason ResolvePrior();
  NotLocalizedReason GatherTiles();
  NotLocalizedReason Match();
  NotLocalizedReason Vote();
  NotLocalizedReason FindCameraAndVote();
  NotLocalizedReason EstimatePoses();
  NotLocalizedReason Refine();

  bool DeadlinePassed() const { return query_.deadline && Clock::now() >= *query_.deadline; }
  // Says when this share of the time from now to the deadline has passed.
  StopFunction StopAfter(double share) const;
  // Makes attempts 0 ... count - 1 until the deadline and adds the poses found to the hypotheses.
  // An attempt gets the consensus below which a pose is of no interest. Returns the number of
  // attempts made.
  int TryInRounds(int count, const std::function<Attempt(int, double)>& attempt);
  void AddHypothesis(Attempt attempt);
  bool NeedsRefinement() const;
  // The `count` hypotheses with most evidence, best first; fewer if there are no more.
  std::vector<const PoseHypothesis*> BestHypotheses(int count) const;
  // Those that see what the best poses so far explain, and those that got most matches.
  std::vector<KeyframeRef> KeyframesToMatch() const;
  // Matches the image against these keyframes and their neighbours, and tries poses on the matches.
  void MatchKeyframes();
  // Refined on the matches of all poses that might have won, not only those among which it was
  // found.
  PoseHypothesis RefinedOnAllMatches(const PoseHypothesis& winner) const;
  // Makes `context_` that of the camera with which the best pose goes, of all that are tried.
  void FindCamera();
  // With the camera that goes with it, if the query or the inliers ask for one; its covariance
  // includes the camera's.
  PoseHypothesis RefinedWithCamera(PoseHypothesis winner) const;
  // See RefinementOptions::max_gravity_error_sigmas.
  bool DoubtsGravity() const;
  // From matching on, as if the query had had no gravity; the hypotheses so far stay.
  void TryWithoutGravity();
  // The context in which the pose was found: with gravity or without.
  const QueryContext& ContextOf(const PoseHypothesis& pose) const {
    return pose.used_gravity && context_with_gravity_ ? *context_with_gravity_ : context_;
  }

  const MapStore& store_;
  TileCache* cache_;
  const LocalizerOptions& options_;
  SharedWorkers* workers_;
  const LocalizeQuery& query_;

  std::optional<MapSnapshot> snapshot_;  // Until the tiles are there.
  QueryContext context_;
  std::optional<QueryContext> context_with_gravity_;  // Once it was tried without.
  std::vector<TileView> tiles_;
  std::shared_ptr<const std::vector<Correspondence>> correspondences_;
  std::vector<PoseCandidate> candidates_;
  std::vector<PoseHypothesis> hypotheses_;
  double best_consensus_ = 0.0;  // Of the hypotheses.
  LocalizeResult result_;
};

LocalizeResult QueryRun::Run() {
  static constexpr std::pair<Stage, StageMethod> kStages[] = {
      {Stage::kPrior, &QueryRun::ResolvePrior}, {Stage::kTiles, &QueryRun::GatherTiles},
      {Stage::kMatching, &QueryRun::Match},     {Stage::kVoting, &QueryRun::FindCameraAndVote},
      {Stage::kPose, &QueryRun::EstimatePoses}, {Stage::kRefinement, &QueryRun::Refine},
  };
  const Clock::time_point start = Clock::now();
  query_.Validate();
  result_.counters.num_keypoints = query_.num_features();
  result_.counters.used_prior = query_.prior.has_value();
  result_.counters.used_gravity = query_.down_in_cam.has_value();
  snapshot_.emplace(store_.Snapshot());
  result_.map_version = snapshot_->version();
  for (const auto& [stage, method] : kStages) {
    if (DeadlinePassed()) {
      result_.reason = NotLocalizedReason::kTimeout;
      break;
    }
    const Clock::time_point stage_start = Clock::now();
    result_.reason = (this->*method)();
    result_.times.seconds[static_cast<size_t>(stage)] = SecondsSince(stage_start);
    if (result_.reason != NotLocalizedReason::kNone) {
      break;
    }
  }
  if (!hypotheses_.empty()) {
    ConcludeAnswer(
        context_, tiles_, hypotheses_, options_.answer,
        [this](const PoseHypothesis& winner) {
          PoseHypothesis refined = RefinedOnAllMatches(winner);
          refined.estimate = RefineOnLikelyInliers(ContextOf(winner), *refined.correspondences,
                                                   std::move(refined.estimate), options_.pose);
          return RefinedWithCamera(std::move(refined));
        },
        &result_);
  }
  if (FoundTooLittle(result_.reason) && (DeadlinePassed() || result_.counters.is_cut_short())) {
    result_.reason = NotLocalizedReason::kTimeout;
  }
  result_.times.total_seconds = SecondsSince(start);
  return std::move(result_);
}

StopFunction QueryRun::StopAfter(double share) const {
  if (!query_.deadline) {
    return {};
  }
  const Clock::time_point now = Clock::now();
  const Clock::time_point end =
      now + std::chrono::duration_cast<Clock::duration>(
                share * std::chrono::duration<double>(*query_.deadline - now));
  return [end] { return Clock::now() >= end; };
}

NotLocalizedReason QueryRun::ResolvePrior() {
  const auto codebook = snapshot_->CurrentCodebook();
  // A prior needs nothing of the map; summing it up is for queries without one.
  const MapInfo map = query_.prior ? MapInfo{} : snapshot_->Info();
  if (codebook == nullptr || (!query_.prior && !map.bounds)) {
    return NotLocalizedReason::kNoCoverage;
  }
  const SearchRegion region = ResolveSearchRegion(query_, map, options_.prior);
  context_ = BuildQueryContext(query_, DescriptorCodec(codebook), region);
  return query_.num_features() < options_.pose.min_inliers ? NotLocalizedReason::kTooFewFeatures
                                                           : NotLocalizedReason::kNone;
}

NotLocalizedReason QueryRun::GatherTiles() {
  tiles_ = FetchTiles(*snapshot_, cache_, options_.tiles, options_.matching.index, &context_.region,
                      &result_.counters, StopAfter(options_.tiles.deadline_share));
  snapshot_.reset();
  for (const TileView& view : tiles_) {
    result_.tiles.push_back(view.tile->id());
  }
  return tiles_.empty() ? NotLocalizedReason::kNoCoverage : NotLocalizedReason::kNone;
}

NotLocalizedReason QueryRun::Match() {
  correspondences_ = std::make_shared<const std::vector<Correspondence>>(
      MatchFeatures(context_, tiles_, options_.matching, &result_.counters, workers_,
                    StopAfter(options_.matching.deadline_share)));
  return result_.counters.num_matched_keypoints < options_.pose.min_inliers
             ? NotLocalizedReason::kTooFewMatches
             : NotLocalizedReason::kNone;
}

NotLocalizedReason QueryRun::Vote() {
  switch (options_.voting.filter) {
    case OutlierFilter::kVoting4d:
    case OutlierFilter::kVoting3d:
      candidates_ =
          context_.level_from_cam
              ? VoteForPoses(context_, *correspondences_, options_.voting, &result_.counters,
                             workers_, [this] { return DeadlinePassed(); })
              : KeyframeCandidates(context_, tiles_, *correspondences_, options_.refinement);
      break;
    case OutlierFilter::kOther:
      candidates_ = options_.voting.other_filter(tiles_, *correspondences_, options_.voting,
                                                 &result_.counters);
      break;
  }
  result_.counters.num_candidates = static_cast<int64_t>(candidates_.size());
  return NotLocalizedReason::kNone;
}

NotLocalizedReason QueryRun::FindCameraAndVote() {
  if (query_.focal && query_.focal->log_sigma > kMaxTrustedFocalLogSigma) {
    FindCamera();
  }
  return Vote();
}

void QueryRun::FindCamera() {
  constexpr int kNumRefined = 2;
  const QueryContext stated = context_;
  const CameraPrior prior = CameraPriorOf(query_);
  FocalSearch search(prior.focal, options_.refinement.good_evidence);
  Camera best_camera = prior.camera;
  double best_score = 0.0;
  while (const auto factor = DeadlinePassed() ? std::nullopt : search.Next()) {
    context_ = WithCamera(stated, WithFocalScaled(prior.camera, *factor));
    Vote();
    EstimatePoses();
    double score = 0.0;
    for (const PoseHypothesis* pose : BestHypotheses(kNumRefined)) {
      if (pose->estimate.evidence < kMinShareOfBest * best_score) {
        continue;
      }
      const auto refined =
          RefineWithCamera(context_, *pose->correspondences, pose->estimate, prior, options_.pose);
      if (refined && refined->estimate.evidence > score) {
        score = refined->estimate.evidence;
        if (score > best_score) {
          best_score = score;
          best_camera = refined->camera.camera;
        }
      }
    }
    search.Report(score);
    hypotheses_.clear();
  }
  context_ = WithCamera(stated, best_camera);
  best_consensus_ = 0.0;
}

PoseHypothesis QueryRun::RefinedWithCamera(PoseHypothesis winner) const {
  if (context_.is_rig()) {
    return winner;
  }
  const CameraPrior prior = CameraPriorOf(query_);
  AnsweredCamera refined =
      RefineAnswer(ContextOf(winner), *winner.correspondences, std::move(winner.estimate), prior,
                   /*keep_if_possible=*/!query_.focal, options_.pose);
  winner.estimate = std::move(refined.estimate);
  if (refined.camera) {
    winner.camera = MakeCameraEstimate(prior, *refined.camera);
  }
  return winner;
}

NotLocalizedReason QueryRun::EstimatePoses() {
  const auto num_candidates = static_cast<int>(candidates_.size());
  const int num_tried = TryInRounds(num_candidates, [this](int i, double min_consensus) -> Attempt {
    return {correspondences_,
            EstimatePose(context_, *correspondences_, candidates_[i].correspondences, options_.pose,
                         options_.seed, min_consensus)};
  });
  result_.counters.pose_cut_short |= num_tried < num_candidates;
  return NotLocalizedReason::kNone;
}

NotLocalizedReason QueryRun::Refine() {
  if (NeedsRefinement()) {
    MatchKeyframes();
  }
  if (DoubtsGravity()) {
    TryWithoutGravity();
  }
  return hypotheses_.empty() ? NotLocalizedReason::kTooFewInliers : NotLocalizedReason::kNone;
}

std::vector<const PoseHypothesis*> QueryRun::BestHypotheses(int count) const {
  std::vector<const PoseHypothesis*> best;
  for (const PoseHypothesis& hypothesis : hypotheses_) {
    best.push_back(&hypothesis);
  }
  std::stable_sort(best.begin(), best.end(), [](const PoseHypothesis* a, const PoseHypothesis* b) {
    return a->estimate.evidence > b->estimate.evidence;
  });
  best.resize(std::min(best.size(), static_cast<size_t>(count)));
  return best;
}

std::vector<KeyframeRef> QueryRun::KeyframesToMatch() const {
  std::vector<KeyframeRef> keyframes;
  const auto add_first = [&](const std::vector<Correspondence>& correspondences, int count) {
    RefinementOptions options = options_.refinement;
    options.max_keyframes = count;
    for (const RankedKeyframe& ranked : RankKeyframes(context_, tiles_, correspondences, options)) {
      if (std::find(keyframes.begin(), keyframes.end(), ranked.keyframe) == keyframes.end()) {
        keyframes.push_back(ranked.keyframe);
      }
    }
  };
  for (const PoseHypothesis* pose : BestHypotheses(options_.refinement.max_pose_keyframes)) {
    std::vector<Correspondence> inliers;
    for (const int index : pose->estimate.inliers) {
      inliers.push_back((*pose->correspondences)[index]);
    }
    add_first(inliers, 1);
  }
  add_first(*correspondences_, options_.refinement.max_keyframes);
  return keyframes;
}

void QueryRun::MatchKeyframes() {
  const std::vector<KeyframeRef> keyframes = KeyframesToMatch();
  std::vector<int64_t> num_rematches(keyframes.size(), 0);
  const auto attempt = [&](int i, double min_consensus) -> Attempt {
    const auto rematches =
        std::make_shared<const std::vector<Correspondence>>(MatchAgainstKeyframes(
            context_, tiles_,
            KeyframeNeighborhood(tiles_, keyframes[i], options_.refinement.neighbors_per_keyframe),
            options_.refinement.relaxed_distance_quantile, options_.matching));
    num_rematches[i] = static_cast<int64_t>(rematches->size());
    std::vector<int> all(rematches->size());
    std::iota(all.begin(), all.end(), 0);
    return {rematches,
            EstimatePose(context_, *rematches, all, options_.pose, options_.seed, min_consensus)};
  };
  const auto num_keyframes = static_cast<int>(keyframes.size());
  const int num_tried = TryInRounds(num_keyframes, attempt);
  result_.counters.num_refined_keyframes += num_tried;
  result_.counters.refinement_cut_short |= num_tried < num_keyframes;
  result_.counters.num_rematches +=
      std::accumulate(num_rematches.begin(), num_rematches.end(), int64_t{0});
}

PoseHypothesis QueryRun::RefinedOnAllMatches(const PoseHypothesis& winner) const {
  const auto all = std::make_shared<std::vector<Correspondence>>();
  std::vector<const std::vector<Correspondence>*> taken;
  const double min_evidence = kMinShareOfBest * BestHypotheses(1).front()->estimate.evidence;
  for (const PoseHypothesis& hypothesis : hypotheses_) {
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
  auto refined = RefineEstimate(ContextOf(winner), *all, winner.estimate, options_.pose);
  return refined ? PoseHypothesis{std::move(*refined), all, winner.used_gravity, {}} : winner;
}

bool QueryRun::DoubtsGravity() const {
  if (!context_.down_in_cam || options_.refinement.mode == RefinementMode::kNever ||
      options_.pose.solver == MinimalSolver::kGravityTwoPoint || DeadlinePassed()) {
    return false;
  }
  const std::vector<const PoseHypothesis*> best = BestHypotheses(1);
  if (best.empty() || best.front()->estimate.evidence < options_.refinement.min_trusted_evidence) {
    return true;
  }
  const PoseEstimate& estimate = best.front()->estimate;
  const Eigen::Vector3d down_in_cam = estimate.cam_from_anchor.rotation * -Eigen::Vector3d::UnitZ();
  const double tilt_rad = std::acos(std::clamp(down_in_cam.dot(*context_.down_in_cam), -1.0, 1.0));
  return estimate.evidence < options_.refinement.good_evidence &&
         tilt_rad > options_.refinement.max_gravity_error_sigmas * options_.pose.gravity_sigma_rad;
}

void QueryRun::TryWithoutGravity() {
  context_with_gravity_ = context_;
  context_ = WithoutGravity(std::move(context_));
  if (Match() == NotLocalizedReason::kNone && Vote() == NotLocalizedReason::kNone) {
    EstimatePoses();
    if (NeedsRefinement()) {
      MatchKeyframes();
    }
  }
}

// The first attempt is made alone: it succeeds more often than not, and then the others need not
// look for less. They follow four at a time, in parallel if cores are free. Rounds do not depend on
// the number of threads, so neither does the answer.
int QueryRun::TryInRounds(int count, const std::function<Attempt(int, double)>& attempt) {
  constexpr int kRoundSize = 4;
  int num_made = 0;
  for (int begin = 0, end = 1; begin < count; begin = end, end += kRoundSize) {
    std::vector<Attempt> round(std::min(count, end) - begin);
    const double min_consensus = kMinShareOfBest * best_consensus_;
    workers_->ForEach(static_cast<int>(round.size()), [&](int i) {
      if (!DeadlinePassed()) {
        round[i] = attempt(begin + i, min_consensus);
      }
    });
    for (Attempt& made : round) {
      num_made += made.correspondences != nullptr;
      AddHypothesis(std::move(made));
    }
  }
  return num_made;
}

void QueryRun::AddHypothesis(Attempt attempt) {
  if (attempt.estimate) {
    best_consensus_ = std::max(best_consensus_, attempt.estimate->consensus);
    result_.counters.num_ransac_iterations += attempt.estimate->num_iterations;
    hypotheses_.push_back({std::move(*attempt.estimate), std::move(attempt.correspondences),
                           context_.down_in_cam.has_value(), std::nullopt});
  }
}

bool QueryRun::NeedsRefinement() const {
  switch (options_.refinement.mode) {
    case RefinementMode::kNever:
      return false;
    case RefinementMode::kAlways:
      return true;
    case RefinementMode::kWhenWeak:
      break;
  }
  return std::none_of(hypotheses_.begin(), hypotheses_.end(),
                      [this](const PoseHypothesis& hypothesis) {
                        return hypothesis.estimate.evidence >= options_.refinement.good_evidence;
                      });
}

}  // namespace

Localizer::Localizer(std::shared_ptr<const MapStore> store, std::shared_ptr<TileCache> cache,
                     const LocalizerOptions& options) {
  options.Validate();
  impl_.reset(
      new Impl{std::move(store), std::move(cache), options, SharedWorkers(options.num_threads)});
}

Localizer::~Localizer() = default;

LocalizeResult Localizer::Localize(const LocalizeQuery& query) const {
  const SharedWorkers::Caller caller(&impl_->workers);
  QueryRun run(*impl_->store, impl_->cache.get(), impl_->options, &impl_->workers, query);
  LocalizeResult result = run.Run();
  if (result.counters.tiles_cut_short) {
    impl_->finisher.Add(run.region());
  }
  return result;
}

const LocalizerOptions& Localizer::options() const { return impl_->options; }

}  // namespace cairn
