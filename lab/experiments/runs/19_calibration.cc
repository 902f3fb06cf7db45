// Measures whether the confidence is a probability and the accuracies are right, in cities other
// than that of the fit.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "engine/localizer_options.h"
#include "lab/experiments/measure/calibration.h"
#include "lab/experiments/measure/variants.h"
#include "lab/experiments/runs/cities.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

constexpr double kCoverage = 0.68;
constexpr double kCoverageMargin = 0.1;
constexpr double kMaxCalibrationError = 0.05;
// The engine's defaults were fitted to such a city.
constexpr CityCharacter kFittedTo = CityCharacter::kGrid;
// Includes weak answers, so that the fit sees the scores at which answers become wrong.
constexpr double kMinScore = 1.0;

struct CitySamples {
  std::string city;
  std::vector<CalibrationSample> samples;
};

std::vector<CitySamples> MeasureCities(const ExperimentContext& context,
                                       ExperimentOutcome* outcome) {
  LocalizerOptions options;
  options.answer.min_score = kMinScore;
  std::vector<CitySamples> cities;
  for (auto& [city, world_options] : Cities(context)) {
    world_options.num_queries = context.Pick(60, 600);
    const auto world = context.worlds->Get(world_options, context.progress);
    const auto measured = MeasureVariants(*world, {{city, 0.0, options}}, context);
    cities.push_back(
        {city, CalibrationSamples(measured.front().report, options.answer.calibration)});
    outcome->parameters.emplace_back(city, world->description);
    context.worlds->Forget(world_options);
  }
  return cities;
}

ResultTable CalibrationTable() {
  std::vector<Column> columns = {
      {"calibration"}, {"city"}, {"answers"}, {"calibration_error"}, {"brier_score"}};
  AddIntervalColumns("position_coverage", &columns);
  AddIntervalColumns("rotation_coverage", &columns);
  return ResultTable(std::move(columns));
}

void AddRow(const std::string& calibration, const std::string& city,
            const CalibrationReport& report, ResultTable* table) {
  std::vector<Cell> row = {calibration, city, static_cast<double>(report.num_samples),
                           report.expected_calibration_error, report.brier_score};
  AddIntervalCells(report.position_coverage, &row);
  AddIntervalCells(report.rotation_coverage, &row);
  table->AddRow(std::move(row));
}

FigureSeries ReliabilitySeries(const std::string& city, const CalibrationReport& report) {
  FigureSeries series{city, {}};
  for (const ReliabilityBin& bin : report.bins) {
    series.points.push_back({bin.mean_confidence, bin.share_correct});
  }
  return series;
}

Verdict JudgeCity(const CalibrationReport& report) {
  const auto excess = [](const Interval& coverage) {
    return Interval{coverage.value - kCoverage, coverage.low - kCoverage,
                    coverage.high - kCoverage};
  };
  return JudgeAll({JudgeEqual(excess(report.position_coverage), kCoverageMargin),
                   JudgeEqual(excess(report.rotation_coverage), kCoverageMargin),
                   report.expected_calibration_error < kMaxCalibrationError
                       ? Verdict::kHolds
                       : Verdict::kDoesNotHold});
}

ExperimentOutcome RunCalibration(const ExperimentContext& context) {
  ExperimentOutcome outcome;
  outcome.table = CalibrationTable();
  const std::vector<CitySamples> cities = MeasureCities(context, &outcome);
  const CitySamples& fitted_to = *std::find_if(
      cities.begin(), cities.end(),
      [](const CitySamples& city) { return city.city == CityCharacterName(kFittedTo); });
  const ScoreCalibration fit = FitCalibration(fitted_to.samples);
  Figure figure{.name = "19_calibration",
                .title = "Reliability in cities that the fit has not seen",
                .x_label = "confidence",
                .y_label = "share of answers within 3 m and 10 degrees"};
  figure.series = {{"as it should be", {{0.5, {0.5, 0.5, 0.5}}, {1.0, {1.0, 1.0, 1.0}}}}};
  std::vector<Verdict> verdicts;
  for (const CitySamples& city : cities) {
    const CalibrationReport report = MeasureCalibration(city.samples, fit);
    AddRow("fitted to " + fitted_to.city, city.city, report, &outcome.table);
    AddRow("the engine's own", city.city,
           MeasureCalibration(city.samples, AnswerOptions{}.calibration), &outcome.table);
    if (&city != &fitted_to) {
      figure.series.push_back(ReliabilitySeries(city.city, report));
      verdicts.push_back(JudgeCity(report));
      outcome.sentence += fmt::format(
          "{}: calibration error {:.3f}, {} of the positions and {} of the rotations within their "
          "radius. ",
          city.city, report.expected_calibration_error, IntervalText(report.position_coverage),
          IntervalText(report.rotation_coverage));
    }
  }
  outcome.figures = {figure};
  outcome.verdict = JudgeAll(verdicts);
  outcome.sentence +=
      fmt::format("Fitted to {}: slope {:.3f}, offset {:.3f}, factors {:.3f} and {:.3f}.",
                  fitted_to.city, fit.confidence_slope, fit.confidence_offset,
                  fit.position_accuracy_factor, fit.rotation_accuracy_factor);
  return outcome;
}

}  // namespace

Experiment CalibrationExperiment() {
  return {"19_calibration",
          "Calibration of the confidence and the accuracies",
          "not in the paper",
          "The confidence is the probability that a pose is within 3 m and 10°, and 68 % of the "
          "true poses are within the reported radii, in cities other than that of the fit.",
          "holds if in every other city the calibration error is below 0.05 and the intervals of "
          "both coverages are between 0.58 and 0.78; does not hold if one of these values is "
          "outside its limits by its whole interval.",
          "8 min",
          RunCalibration};
}

}  // namespace cairn
