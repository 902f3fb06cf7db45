#include "lab/experiments/measure/variants.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

#include "core/check.h"
#include "core/parallel_for.h"
#include "engine/localizer.h"
#include "lab/bench/thread_cpu_clock.h"
#include "lab/experiments/measure/warm_tiles.h"

namespace cairn {
namespace {

constexpr double kMsFromSeconds = 1e3;

MeasuredVariant Measure(const ExperimentWorld& world, const Variant& variant,
                        std::shared_ptr<TileCache> tiles, int num_threads) {
  MeasuredVariant measured;
  measured.variant = variant;
  const Localizer localizer(world.store, variant.options, std::move(tiles));
  const int num_queries = static_cast<int>(world.queries.size());
  std::vector<LocalizeResult> results(num_queries);
  measured.cpu_seconds.resize(num_queries);
  ParallelFor(num_queries, num_threads, [&](int i) {
    const double start = ThreadCpuSeconds();
    results[i] = localizer.Localize(world.queries[i].query);
    measured.cpu_seconds[i] = ThreadCpuSeconds() - start;
  });
  measured.report = MeasureResults(world.queries, std::move(results));
  return measured;
}

}  // namespace

double MeasuredVariant::MeanCpuSeconds() const {
  return std::accumulate(cpu_seconds.begin(), cpu_seconds.end(), 0.0) /
         static_cast<double>(std::max<size_t>(1, cpu_seconds.size()));
}

LocalizerOptions BestVariant() {
  LocalizerOptions options;
  options.answer.min_score = -std::numeric_limits<double>::infinity();
  options.answer.ambiguous_distance_m = std::numeric_limits<double>::infinity();
  options.answer.ambiguous_rotation_rad = std::numeric_limits<double>::infinity();
  return options;
}

std::vector<MeasuredVariant> MeasureVariants(const ExperimentWorld& world,
                                             const std::vector<Variant>& variants,
                                             const ExperimentContext& context) {
  WarmTiles tiles(world, context.num_threads);
  std::vector<MeasuredVariant> measured;
  for (const Variant& variant : variants) {
    measured.push_back(Measure(world, variant, tiles.For(variant.options), context.num_threads));
    if (context.progress) {
      context.progress("measuring", static_cast<int>(measured.size()),
                       static_cast<int>(variants.size()));
    }
  }
  return measured;
}

const MeasuredVariant& BestOf(const std::vector<MeasuredVariant>& measured,
                              const std::string& method) {
  const MeasuredVariant* best = nullptr;
  for (const MeasuredVariant& candidate : measured) {
    if (candidate.variant.method == method &&
        (best == nullptr ||
         candidate.report.average_precision.value > best->report.average_precision.value)) {
      best = &candidate;
    }
  }
  CAIRN_CHECK(best != nullptr, "no variant of this method was measured");
  return *best;
}

const MeasuredVariant& At(const std::vector<MeasuredVariant>& measured, const std::string& method,
                          double x) {
  const auto found =
      std::find_if(measured.begin(), measured.end(), [&](const MeasuredVariant& candidate) {
        return candidate.variant.method == method && candidate.variant.x == x;
      });
  CAIRN_CHECK(found != measured.end(), "no such variant was measured");
  return *found;
}

Interval ApDifference(const MeasuredVariant& a, const MeasuredVariant& b) {
  return PairedDifference(a.report, b.report, AccuracyMeasure::kAveragePrecision);
}

ResultTable AccuracyTable(const std::string& x_name, const std::vector<MeasuredVariant>& measured,
                          const MeasuredVariant& reference) {
  std::vector<Column> columns = {{"method"}, {x_name}};
  AddIntervalColumns("average_precision", &columns);
  AddIntervalColumns("recall_3m_10deg", &columns);
  AddIntervalColumns("median_position_m", &columns);
  columns.push_back({"cpu_ratio", true});
  columns.push_back({"cpu_ms", true});
  ResultTable table(std::move(columns));
  for (const MeasuredVariant& row : measured) {
    std::vector<Cell> cells = {row.variant.method, row.variant.x};
    AddIntervalCells(row.report.average_precision, &cells);
    AddIntervalCells(MeasureAccuracy(row.report, AccuracyMeasure::kRecallAtCorrect), &cells);
    AddIntervalCells(row.report.median_position_error_m, &cells);
    cells.emplace_back(row.MeanCpuSeconds() / reference.MeanCpuSeconds());
    cells.emplace_back(kMsFromSeconds * row.MeanCpuSeconds());
    table.AddRow(std::move(cells));
  }
  return table;
}

Figure AccuracyFigure(const std::string& name, const std::string& title, const std::string& x_label,
                      const std::vector<MeasuredVariant>& measured) {
  Figure figure;
  figure.name = name;
  figure.title = title;
  figure.x_label = x_label;
  figure.y_label = "average precision";
  for (const MeasuredVariant& point : measured) {
    auto series = std::find_if(
        figure.series.begin(), figure.series.end(),
        [&](const FigureSeries& known) { return known.label == point.variant.method; });
    if (series == figure.series.end()) {
      series = figure.series.insert(series, {point.variant.method, {}});
    }
    series->points.push_back({point.variant.x, point.report.average_precision});
  }
  return figure;
}

ExperimentParameters WorldParameters(const ExperimentWorld& world) {
  return {{"world", world.description},
          {"tiles", fmt::format("{}", world.info.num_tiles)},
          {"landmarks", fmt::format("{}", world.info.num_landmarks)},
          {"descriptors", fmt::format("{}", world.info.num_descriptors)},
          {"queries", fmt::format("{}", world.queries.size())}};
}

}  // namespace cairn
