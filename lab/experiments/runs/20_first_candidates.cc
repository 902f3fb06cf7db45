// Measures the rank of the true pose among the candidates of an outlier filter when few matches are
// right.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/parallel_for.h"
#include "core/random.h"
#include "engine/matching/match_features.h"
#include "engine/pose/estimate_pose.h"
#include "engine/voting/pose_voting.h"
#include "eval/evaluation.h"
#include "lab/experiments/measure/right_landmarks.h"
#include "lab/experiments/measure/variants.h"
#include "lab/experiments/measure/warm_tiles.h"
#include "lab/experiments/runs/filters.h"
#include "lab/experiments/runs/runs.h"
#include "lab/rivals/covisibility_filter.h"

namespace cairn {
namespace {

constexpr int kNumFirst = 5;
constexpr double kMinShareFirst = 0.95;
constexpr double kFewRight = 0.015;
const NamedFilter kFilters[] = {kVoting, kVotingFlat, kCovisible};
constexpr size_t kNumFilters = std::size(kFilters);

// The result of one query.
struct Ranking {
  // The pose can be found from the right matches alone or from a candidate of some filter.
  bool is_solvable = false;
  int num_matches = 0;
  int num_right = 0;
  // Index of the first candidate that leads to the true pose; null if none does.
  std::optional<int> rank_of_truth[kNumFilters];
};

struct QueryMatchSet {
  std::vector<Correspondence> matches;
  std::vector<int> right;  // Indices into matches.
};

// Returns the matches of a query with at most `max_right_share` right ones. Excess right matches
// are left out at random.
QueryMatchSet MatchesWithFewRight(const PreparedQuery& query, const Rigid3d& true_cam_from_anchor,
                                  const MatchingOptions& options, double max_right_share,
                                  uint64_t seed) {
  const std::vector<Correspondence> all =
      MatchFeatures(query.context, query.tiles, options).correspondences;
  std::vector<bool> is_right(all.size());
  int num_right = 0;
  for (size_t i = 0; i < all.size(); ++i) {
    is_right[i] = IsRight(query.context, true_cam_from_anchor, all[i].keypoint_idx,
                          all[i].x_in_anchor, all[i].sigma_m);
    num_right += is_right[i];
  }
  const double num_wrong = static_cast<double>(all.size()) - num_right;
  int num_to_keep = static_cast<int>(std::min(
      static_cast<double>(num_right), num_wrong * max_right_share / (1.0 - max_right_share)));
  QueryMatchSet kept;
  Random random(seed);
  for (size_t i = 0; i < all.size(); ++i) {
    if (is_right[i]) {
      // Keeps the required number of the remaining right matches. Every subset is equally likely.
      const bool keeps = random.Index(num_right--) < num_to_keep;
      if (!keeps) {
        continue;
      }
      --num_to_keep;
      kept.right.push_back(static_cast<int>(kept.matches.size()));
    }
    kept.matches.push_back(all[i]);
  }
  return kept;
}

bool LeadsToTruth(const QueryContext& query, const std::vector<Correspondence>& matches,
                  const std::vector<int>& subset, const Rigid3d& true_cam_from_anchor,
                  const LocalizerOptions& options) {
  const auto estimate = EstimatePose(query, matches, subset, options.pose, options.seed);
  if (!estimate) {
    return false;
  }
  const Rigid3d& found = estimate->cam_from_anchor;
  const Eigen::Vector3d offset_m =
      found.Inverse().translation - true_cam_from_anchor.Inverse().translation;
  return offset_m.norm() <= kCorrect.position_m &&
         RotationAngleRad(found.rotation, true_cam_from_anchor.rotation) <= kCorrect.rotation_rad;
}

std::vector<PoseCandidate> CandidatesOf(const PreparedQuery& query,
                                        const std::vector<Correspondence>& matches,
                                        const VotingOptions& options) {
  return options.filter == OutlierFilter::kOther
             ? options.other_filter(query.tiles, matches, options)
             : VoteForPoses(query.context, matches, options).candidates;
}

Ranking Rank(const PreparedQuery& query, const Rigid3d& true_cam_from_anchor,
             const LocalizerOptions& options, double max_right_share, uint64_t seed) {
  const QueryMatchSet set =
      MatchesWithFewRight(query, true_cam_from_anchor, options.matching, max_right_share, seed);
  const auto leads_to_truth = [&](const std::vector<int>& subset) {
    return LeadsToTruth(query.context, set.matches, subset, true_cam_from_anchor, options);
  };
  Ranking ranking;
  ranking.num_matches = static_cast<int>(set.matches.size());
  ranking.num_right = static_cast<int>(set.right.size());
  ranking.is_solvable = leads_to_truth(set.right);
  for (size_t f = 0; f < kNumFilters; ++f) {
    const auto candidates =
        CandidatesOf(query, set.matches, kFilters[f].with_filter(options.voting));
    const auto found = std::find_if(
        candidates.begin(), candidates.end(),
        [&](const PoseCandidate& candidate) { return leads_to_truth(candidate.correspondences); });
    if (found != candidates.end()) {
      ranking.rank_of_truth[f] = static_cast<int>(found - candidates.begin());
      ranking.is_solvable = true;
    }
  }
  return ranking;
}

std::vector<Ranking> RankAll(const ExperimentWorld& world, const ExperimentContext& context,
                             WarmTiles* tiles, double max_right_share) {
  const LocalizerOptions options = BestVariant();
  const std::shared_ptr<TileCache> cache = tiles->For(options);
  std::vector<Ranking> rankings(world.queries.size());
  ParallelFor(static_cast<int>(rankings.size()), context.num_threads, [&](int i) {
    const EvalQuery& query = world.queries[i];
    const PreparedQuery prepared = PrepareQuery(world, options, query, cache.get());
    rankings[i] = Rank(prepared, query.cam_from_ecef * prepared.context.region.ecef_from_anchor,
                       options, max_right_share, context.seed + static_cast<uint64_t>(i));
  });
  return rankings;
}

// Returns the share of solvable queries whose true pose is among the first `num_first` candidates
// of a filter.
Interval ShareAmongFirst(const std::vector<Ranking>& rankings, size_t filter, int num_first) {
  std::vector<double> hits;
  for (const Ranking& ranking : rankings) {
    if (ranking.is_solvable) {
      const std::optional<int>& rank = ranking.rank_of_truth[filter];
      hits.push_back(rank && *rank < num_first ? 1.0 : 0.0);
    }
  }
  return Bootstrap(hits.size(), [&](std::span<const size_t> sample) {
    double sum = 0.0;
    for (const size_t i : sample) {
      sum += hits[i];
    }
    return sum / static_cast<double>(sample.size());
  });
}

double MeanOf(const std::vector<Ranking>& rankings, int Ranking::*count) {
  double sum = 0.0;
  for (const Ranking& ranking : rankings) {
    sum += ranking.*count;
  }
  return sum / static_cast<double>(rankings.size());
}

ResultTable RankingTable() {
  std::vector<Column> columns = {
      {"method"}, {"most_right_share"}, {"matches_a_query"}, {"right_ones"}, {"solvable_queries"}};
  for (const char* name : {"truth_is_first", "truth_among_first_5", "truth_among_all"}) {
    AddIntervalColumns(name, &columns);
  }
  return ResultTable(std::move(columns));
}

int64_t NumSolvable(const std::vector<Ranking>& rankings) {
  return std::count_if(rankings.begin(), rankings.end(),
                       [](const Ranking& ranking) { return ranking.is_solvable; });
}

void AddRow(const std::vector<Ranking>& rankings, size_t filter, double max_right_share,
            ResultTable* table) {
  std::vector<Cell> row = {
      kFilters[filter].name, max_right_share, MeanOf(rankings, &Ranking::num_matches),
      MeanOf(rankings, &Ranking::num_right), static_cast<double>(NumSolvable(rankings))};
  for (const int num_first : {1, kNumFirst, BestVariant().voting.max_candidates}) {
    AddIntervalCells(ShareAmongFirst(rankings, filter, num_first), &row);
  }
  table->AddRow(std::move(row));
}

// Judges the claim, which is about the first filter with few right matches.
void Judge(const std::vector<Ranking>& few_right, ExperimentOutcome* outcome) {
  const Interval first_five = ShareAmongFirst(few_right, 0, kNumFirst);
  outcome->verdict = JudgeGreater(first_five, kMinShareFirst);
  outcome->sentence = fmt::format(
      "With at most {} % of the matches right, {} of {} queries can be solved. For the solvable "
      "queries, the share for which {} has the true pose among its first {} candidates is {}.",
      100.0 * kFewRight, NumSolvable(few_right), few_right.size(), kFilters[0].name, kNumFirst,
      IntervalText(first_five));
}

ExperimentOutcome RunFirstCandidates(const ExperimentContext& context) {
  const auto world = context.worlds->Get(StandardWorld(context), context.progress);
  const auto shares =
      context.Pick<std::vector<double>>({kFewRight}, {0.0075, 0.01, kFewRight, 0.02, 0.03, 0.1});
  ExperimentOutcome outcome;
  outcome.parameters = WorldParameters(*world);
  outcome.table = RankingTable();
  Figure figure{.name = "20_first_candidates",
                .title = "The truth among the first five candidates",
                .x_label = "right matches at most, per cent",
                .y_label = "share of the solvable queries",
                .log_x = true};
  WarmTiles tiles(*world, context.num_threads);
  std::vector<std::vector<Ranking>> by_share;
  for (const double share : shares) {
    by_share.push_back(RankAll(*world, context, &tiles, share));
    if (share == kFewRight) {
      Judge(by_share.back(), &outcome);
    }
    if (context.progress) {
      context.progress("ranking", static_cast<int>(by_share.size()),
                       static_cast<int>(shares.size()));
    }
  }
  for (size_t f = 0; f < kNumFilters; ++f) {
    figure.series.push_back({kFilters[f].name, {}});
    for (size_t i = 0; i < shares.size(); ++i) {
      AddRow(by_share[i], f, shares[i], &outcome.table);
      figure.series[f].points.push_back(
          {100.0 * shares[i], ShareAmongFirst(by_share[i], f, kNumFirst)});
    }
  }
  outcome.figures = {figure};
  return outcome;
}

}  // namespace

Experiment FirstCandidatesExperiment() {
  return {"20_first_candidates",
          "The true pose among the first candidates",
          "not in the paper",
          "With 1.5 % of the matches right, the true pose is among the first five candidates of "
          "voting for 95 % of the solvable queries.",
          "holds if the interval of the share is above 0.95; does not hold if it is below. A "
          "candidate is right if its correspondences give the pose within 3 m and 10°. A query is "
          "solvable if its right matches alone, or a candidate of some filter, give the pose. "
          "Right matches beyond the given share are left out at random.",
          "2 min",
          RunFirstCandidates};
}

}  // namespace cairn
