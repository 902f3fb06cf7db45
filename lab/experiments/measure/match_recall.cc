#include "lab/experiments/measure/match_recall.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <numeric>
#include <span>

#include "core/check.h"
#include "core/parallel_for.h"
#include "engine/matching/match_features.h"
#include "lab/bench/thread_cpu_clock.h"
#include "lab/experiments/measure/right_landmarks.h"
#include "lab/experiments/measure/warm_tiles.h"

namespace cairn {
namespace {

constexpr double kMsPerSecond = 1e3;

// Returns the sum of one count over the sample, divided by the sum of another.
double Ratio(const std::vector<QueryMatches>& queries, std::span<const size_t> sample,
             int QueryMatches::*numerator, int QueryMatches::*denominator) {
  double above = 0.0, below = 0.0;
  for (const size_t i : sample) {
    above += queries[i].*numerator;
    below += queries[i].*denominator;
  }
  return below == 0.0 ? std::numeric_limits<double>::quiet_NaN() : above / below;
}

double Recall(const std::vector<QueryMatches>& queries, std::span<const size_t> sample) {
  return Ratio(queries, sample, &QueryMatches::num_found, &QueryMatches::num_matchable);
}

QueryMatches MatchOne(const ExperimentWorld& world, const Variant& variant, const EvalQuery& query,
                      const std::vector<bool>& matchable, TileCache* cache) {
  const PreparedQuery prepared = PrepareQuery(world, variant.options, query, cache);
  const Rigid3d true_cam_from_anchor =
      query.cam_from_ecef * prepared.context.region.ecef_from_anchor;
  QueryMatches matches;
  const double start = ThreadCpuSeconds();
  const FeatureMatches all =
      MatchFeatures(prepared.context, prepared.tiles, variant.options.matching);
  matches.cpu_seconds = ThreadCpuSeconds() - start;
  matches.num_distances = all.num_distances;
  matches.num_matches = static_cast<int>(all.correspondences.size());
  std::vector<bool> found(prepared.context.keypoints.size(), false);
  for (const Correspondence& match : all.correspondences) {
    if (IsRight(prepared.context, true_cam_from_anchor, match.keypoint_idx, match.x_in_anchor,
                match.sigma_m)) {
      ++matches.num_right;
      found[match.keypoint_idx] = matchable[match.keypoint_idx];
    }
  }
  matches.num_matchable = static_cast<int>(std::count(matchable.begin(), matchable.end(), true));
  matches.num_found = static_cast<int>(std::count(found.begin(), found.end(), true));
  return matches;
}

MeasuredMatching Measure(const ExperimentWorld& world, const Variant& variant,
                         const std::vector<std::vector<bool>>& matchable, TileCache* tiles,
                         int num_threads) {
  MeasuredMatching measured;
  measured.variant = variant;
  measured.queries.resize(world.queries.size());
  ParallelFor(static_cast<int>(world.queries.size()), num_threads, [&](int i) {
    measured.queries[i] = MatchOne(world, variant, world.queries[i], matchable[i], tiles);
  });
  const std::vector<QueryMatches>& queries = measured.queries;
  measured.recall = Bootstrap(
      queries.size(), [&](std::span<const size_t> sample) { return Recall(queries, sample); });
  measured.precision = Bootstrap(queries.size(), [&](std::span<const size_t> sample) {
    return Ratio(queries, sample, &QueryMatches::num_right, &QueryMatches::num_matches);
  });
  return measured;
}

std::vector<std::vector<bool>> MatchableOfQueries(const ExperimentWorld& world, WarmTiles* tiles,
                                                  int num_threads) {
  const LocalizerOptions options = BestVariant();
  const std::shared_ptr<TileCache> cache = tiles->For(options);
  std::vector<std::vector<bool>> matchable(world.queries.size());
  ParallelFor(static_cast<int>(world.queries.size()), num_threads, [&](int i) {
    const EvalQuery& query = world.queries[i];
    const PreparedQuery prepared = PrepareQuery(world, options, query, cache.get());
    matchable[i] = MatchableKeypoints(
        prepared, query.cam_from_ecef * prepared.context.region.ecef_from_anchor);
  });
  return matchable;
}

}  // namespace

double MeasuredMatching::MeanCpuSeconds() const {
  double sum = 0.0;
  for (const QueryMatches& query : queries) {
    sum += query.cpu_seconds;
  }
  return sum / static_cast<double>(std::max<size_t>(1, queries.size()));
}

double MeasuredMatching::MeanDistances() const {
  double sum = 0.0;
  for (const QueryMatches& query : queries) {
    sum += static_cast<double>(query.num_distances);
  }
  return sum / static_cast<double>(std::max<size_t>(1, queries.size()));
}

std::vector<MeasuredMatching> MeasureMatching(const ExperimentWorld& world,
                                              const std::vector<Variant>& variants,
                                              const ExperimentContext& context) {
  WarmTiles tiles(world, context.num_threads);
  const std::vector<std::vector<bool>> matchable =
      MatchableOfQueries(world, &tiles, context.num_threads);
  std::vector<MeasuredMatching> measured;
  for (const Variant& variant : variants) {
    measured.push_back(
        Measure(world, variant, matchable, tiles.For(variant.options).get(), context.num_threads));
    if (context.progress) {
      context.progress("matching", static_cast<int>(measured.size()),
                       static_cast<int>(variants.size()));
    }
  }
  return measured;
}

Interval RecallDifference(const MeasuredMatching& a, const MeasuredMatching& b) {
  CAIRN_CHECK(a.queries.size() == b.queries.size(), "answers to the same queries are compared");
  return Bootstrap(a.queries.size(), [&](std::span<const size_t> sample) {
    return Recall(a.queries, sample) - Recall(b.queries, sample);
  });
}

const MeasuredMatching& BestRecallOf(const std::vector<MeasuredMatching>& measured,
                                     const std::string& method) {
  const MeasuredMatching* best = nullptr;
  for (const MeasuredMatching& candidate : measured) {
    if (candidate.variant.method == method &&
        (best == nullptr || candidate.recall.value > best->recall.value)) {
      best = &candidate;
    }
  }
  CAIRN_CHECK(best != nullptr, "no variant of this method was measured");
  return *best;
}

ResultTable MatchingTable(const std::string& x_name, const std::vector<MeasuredMatching>& measured,
                          const MeasuredMatching& reference) {
  std::vector<Column> columns = {{"method"}, {x_name}};
  AddIntervalColumns("match_recall", &columns);
  AddIntervalColumns("match_precision", &columns);
  columns.push_back({"distances_a_query"});
  columns.push_back({"cpu_ratio", true});
  columns.push_back({"cpu_ms", true});
  ResultTable table(std::move(columns));
  for (const MeasuredMatching& row : measured) {
    std::vector<Cell> cells = {row.variant.method, row.variant.x};
    AddIntervalCells(row.recall, &cells);
    AddIntervalCells(row.precision, &cells);
    cells.emplace_back(row.MeanDistances());
    cells.emplace_back(row.MeanCpuSeconds() / reference.MeanCpuSeconds());
    cells.emplace_back(kMsPerSecond * row.MeanCpuSeconds());
    table.AddRow(std::move(cells));
  }
  return table;
}

}  // namespace cairn
