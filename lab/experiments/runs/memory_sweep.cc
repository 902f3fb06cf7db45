#include "lab/experiments/runs/memory_sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/check.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

double PerTile(int64_t count, const MapInfo& info) {
  return static_cast<double>(count) / static_cast<double>(std::max<int64_t>(1, info.num_tiles));
}

}  // namespace

std::vector<MeasuredIngest> MeasureIngest(const ExperimentWorldOptions& world,
                                          const std::vector<IngestVariant>& variants,
                                          const ExperimentContext& context) {
  ExperimentContext quiet = context;
  quiet.progress = {};
  std::vector<MeasuredIngest> measured;
  for (const IngestVariant& variant : variants) {
    ExperimentWorldOptions options = world;
    options.ingest = variant.ingest;
    options.ingest_name = fmt::format("variant{}", measured.size());
    const auto built = context.worlds->Get(options, {});
    const Variant best{variant.method, variant.knob, BestVariant()};
    measured.push_back({variant, built->info, MeasureVariants(*built, {best}, quiet).front()});
    context.worlds->Forget(options);
    if (context.progress) {
      context.progress("ingesting and measuring", static_cast<int>(measured.size()),
                       static_cast<int>(variants.size()));
    }
  }
  return measured;
}

const MeasuredIngest& At(const std::vector<MeasuredIngest>& measured, const std::string& method,
                         double knob) {
  const auto found =
      std::find_if(measured.begin(), measured.end(), [&](const MeasuredIngest& candidate) {
        return candidate.variant.method == method && candidate.variant.knob == knob;
      });
  CAIRN_CHECK(found != measured.end(), "no such variant was measured");
  return *found;
}

ResultTable MemoryTable(const std::string& knob_name, const std::vector<MeasuredIngest>& measured) {
  std::vector<Column> columns = {
      {"method"}, {knob_name}, {"megabytes_a_tile"}, {"landmarks_a_tile"}, {"descriptors_a_tile"}};
  AddIntervalColumns("average_precision", &columns);
  AddIntervalColumns("recall_3m_10deg", &columns);
  columns.push_back({"cpu_ratio", true});
  ResultTable table(std::move(columns));
  for (const MeasuredIngest& row : measured) {
    std::vector<Cell> cells = {row.variant.method, row.variant.knob, row.MegabytesPerTile(),
                               PerTile(row.info.num_landmarks, row.info),
                               PerTile(row.info.num_descriptors, row.info)};
    AddIntervalCells(row.answers.report.average_precision, &cells);
    AddIntervalCells(MeasureAccuracy(row.answers.report, AccuracyMeasure::kRecallAtCorrect),
                     &cells);
    cells.emplace_back(row.answers.MeanCpuSeconds() / measured.front().answers.MeanCpuSeconds());
    table.AddRow(std::move(cells));
  }
  return table;
}

Figure MemoryFigure(const std::string& name, const std::string& title,
                    const std::vector<MeasuredIngest>& measured) {
  Figure figure{name, title, "megabytes a tile", "average precision"};
  for (const MeasuredIngest& point : measured) {
    auto series = std::find_if(
        figure.series.begin(), figure.series.end(),
        [&](const FigureSeries& known) { return known.label == point.variant.method; });
    if (series == figure.series.end()) {
      series = figure.series.insert(series, {point.variant.method, {}});
    }
    series->points.push_back({point.MegabytesPerTile(), point.answers.report.average_precision});
  }
  return figure;
}

Interval MeanApDifference(const std::vector<MeasuredIngest>& measured, const std::string& a,
                          const std::string& b, const std::vector<double>& knobs) {
  std::vector<ReportPair> pairs;
  for (const double knob : knobs) {
    pairs.emplace_back(&At(measured, a, knob).answers.report,
                       &At(measured, b, knob).answers.report);
  }
  return MeanPairedDifference(pairs, AccuracyMeasure::kAveragePrecision);
}

ExperimentWorldOptions MemoryWorld(const ExperimentContext& context) {
  ExperimentWorldOptions options = StandardWorld(context);
  options.num_queries = context.NumQueries(8, 150);
  return options;
}

ExperimentParameters MemoryParameters(const ExperimentWorldOptions& world,
                                      const std::vector<MeasuredIngest>& measured) {
  return {{"world", world.Key()},
          {"tiles", fmt::format("{}", measured.front().info.num_tiles)},
          {"queries", fmt::format("{}", world.num_queries)}};
}

}  // namespace cairn
