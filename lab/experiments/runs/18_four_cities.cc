// Measures four cities of different character with one setting: the paper's table of data sets.
#include <fmt/format.h>

#include <string>
#include <vector>

#include "core/angles.h"
#include "lab/experiments/measure/evaluation_size.h"
#include "lab/experiments/measure/variants.h"
#include "lab/experiments/runs/cities.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

constexpr double kUsefulRecall = 0.5;

ResultTable CityTable() {
  std::vector<Column> columns = {
      {"city"},   {"tiles"}, {"landmarks_a_tile"}, {"megabytes_a_tile"}, {"bytes_a_descriptor"},
      {"queries"}};
  for (const char* name : {"average_precision", "recall_3m_10deg", "recall_0.5m_5deg",
                           "median_position_m", "median_rotation_deg"}) {
    AddIntervalColumns(name, &columns);
  }
  columns.push_back({"cpu_ms", true});
  return ResultTable(std::move(columns));
}

Interval Scaled(const Interval& interval, double scale) {
  return {scale * interval.value, scale * interval.low, scale * interval.high};
}

void AddRow(const std::string& city, const ExperimentWorld& world, const MeasuredVariant& measured,
            ResultTable* table) {
  const MapSizes sizes = MeasureMapSizes(world.info);
  const auto num_tiles = static_cast<double>(world.info.num_tiles);
  std::vector<Cell> row = {city,
                           num_tiles,
                           static_cast<double>(world.info.num_landmarks) / num_tiles,
                           1e-6 * sizes.bytes_per_tile,
                           sizes.bytes_per_descriptor,
                           static_cast<double>(world.queries.size())};
  const EvalReport& report = measured.report;
  AddIntervalCells(report.average_precision, &row);
  AddIntervalCells(MeasureAccuracy(report, AccuracyMeasure::kRecallAtCorrect), &row);
  AddIntervalCells(MeasureAccuracy(report, AccuracyMeasure::kRecallAtHalfMeter), &row);
  AddIntervalCells(report.median_position_error_m, &row);
  AddIntervalCells(Scaled(report.median_rotation_error_rad, kDegPerRad), &row);
  row.emplace_back(1e3 * measured.MeanCpuSeconds());
  table->AddRow(std::move(row));
}

ExperimentOutcome RunFourCities(const ExperimentContext& context) {
  ExperimentOutcome outcome;
  outcome.table = CityTable();
  Figure figure{"18_four_cities", "Four cities at one setting", "city", "share of queries"};
  figure.series = {{"average precision", {}}, {"recall at 3 m, 10 degrees", {}}};
  std::vector<Verdict> verdicts;
  for (auto [city, options] : Cities(context)) {
    options.hard_queries = false;  // Ordinary phone queries.
    const auto world = context.worlds->Get(options, context.progress);
    const auto measured = MeasureVariants(*world, {{city, 0.0, BestVariant()}}, context);
    AddRow(city, *world, measured.front(), &outcome.table);
    const Interval recall =
        MeasureAccuracy(measured.front().report, AccuracyMeasure::kRecallAtCorrect);
    const auto x = static_cast<double>(figure.x_names.size());
    figure.x_names.push_back(city);
    figure.series[0].points.push_back({x, measured.front().report.average_precision});
    figure.series[1].points.push_back({x, recall});
    verdicts.push_back(JudgeGreater(recall, kUsefulRecall));
    outcome.sentence +=
        fmt::format("{}{} {}", outcome.sentence.empty() ? "" : ", ", city, IntervalText(recall));
    outcome.parameters.emplace_back(city, world->description);
  }
  outcome.figures = {figure};
  outcome.verdict = JudgeAll(verdicts);
  outcome.sentence = "Recall within 3 m and 10° of all queries: " + outcome.sentence + ".";
  return outcome;
}

}  // namespace

Experiment FourCitiesExperiment() {
  return {
      "18_four_cities",
      "Four cities of different character at one setting",
      "Table 1 and abstract",
      "One system with one setting localizes phones in four cities of different character.",
      "holds if in every city more than half of all queries are answered within 3 m and 10°, by "
      "the interval of the recall; does not hold if the whole interval of one city is below half.",
      "2 min",
      RunFourCities};
}

}  // namespace cairn
