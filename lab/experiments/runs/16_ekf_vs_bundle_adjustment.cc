// Compares the filter with sliding-window bundle adjustment: time and accuracy of global updates.
#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "lab/experiments/runs/fusion_scenes.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

constexpr double kSamePosition = 1.1;  // Ratios up to this count as equal.
constexpr double kMuchFaster = 10.0;

double UpdateMs(const fusion::MethodResult& result) { return 1e3 * result.update_seconds.mean; }
double NumMatches(const fusion::MethodResult& result) { return result.mean_matches; }

ResultTable EstimatorTable(const std::vector<FusionScene>& scenes) {
  std::vector<Column> columns = {{"scene"}, {"method"}};
  AddIntervalColumns("position_rmse_m", &columns);
  AddIntervalColumns("rotation_rmse_deg", &columns);
  columns.push_back({"matches_an_update"});
  columns.push_back({"update_ms", true});
  columns.push_back({"update_ratio", true});
  ResultTable table(std::move(columns));
  for (const FusionScene& scene : scenes) {
    for (size_t method = 0; method < scene.methods.size(); ++method) {
      std::vector<Cell> row = {scene.name, scene.methods[method]};
      AddIntervalCells(MeanOver(scene, method, PositionRmseM), &row);
      AddIntervalCells(MeanOver(scene, method, RotationRmseDeg), &row);
      row.emplace_back(MeanOver(scene, method, NumMatches).value);
      row.emplace_back(MeanOver(scene, method, UpdateMs).value);
      row.emplace_back(RatioOver(scene, method, kFilter, UpdateMs).value);
      table.AddRow(std::move(row));
    }
  }
  return table;
}

std::string SpeedText(const Interval& speed, const std::string& fastest) {
  return std::isfinite(speed.value) ? fmt::format("{} takes {} times as long for an update.",
                                                  fastest, IntervalText(speed, 1))
                                    : "The filter had no update to be timed.";
}

// Judges one scene and appends the reason to `sentence`.
Verdict JudgeEstimator(const FusionScene& scene, std::string* sentence) {
  const size_t nearest = BestRival(scene, PositionRmseM);
  const size_t straightest = BestRival(scene, RotationRmseDeg);
  const size_t fastest = BestRival(scene, UpdateMs);
  const Interval position = RatioOver(scene, kFilter, nearest, PositionRmseM);
  const Interval rotation = RatioOver(scene, kFilter, straightest, RotationRmseDeg);
  const Interval speed = RatioOver(scene, fastest, kFilter, UpdateMs);
  *sentence += fmt::format(
      "{}{}: the filter's position error is {} times that of the best bundle adjustment ({}). The "
      "filter's rotation error is {} times that of the best bundle adjustment ({}). {} For the "
      "filter's pose for displays, the position ratio is {} and the rotation ratio is {}.",
      sentence->empty() ? "" : " ", scene.name, IntervalText(position, 2), scene.methods[nearest],
      IntervalText(rotation, 2), scene.methods[straightest],
      SpeedText(speed, scene.methods[fastest]),
      IntervalText(RatioOver(scene, kSteadyFilter, nearest, PositionRmseM), 2),
      IntervalText(RatioOver(scene, kSteadyFilter, straightest, RotationRmseDeg), 2));
  return JudgeAll({JudgeSmaller(position, kSamePosition), JudgeSmaller(rotation, 1.0),
                   JudgeGreater(speed, kMuchFaster)});
}

ExperimentOutcome RunEkfVsBundleAdjustment(const ExperimentContext& context) {
  const std::vector<FusionScene> scenes = RunFusionScenes(context, fusion::PaperVariants(), false);
  ExperimentOutcome outcome;
  outcome.parameters = FusionParameters(context);
  outcome.table = EstimatorTable(scenes);
  outcome.figures = {SceneFigure("16_ekf_vs_bundle_adjustment", "Position after global updates",
                                 "position error, m (root mean square)", scenes, PositionRmseM)};
  outcome.verdict = JudgeScenes(scenes, JudgeEstimator, &outcome.sentence);
  return outcome;
}

}  // namespace

Experiment EkfVsBundleAdjustmentExperiment() {
  return {
      "16_ekf_vs_bundle_adjustment",
      "The filter against bundle adjustment in a sliding window",
      "Table 2",
      "A filter that includes the matches directly is as accurate in position as bundle adjustment "
      "in a sliding window, more accurate in orientation, and more than ten times as fast.",
      "holds if three conditions are met in every scene, by intervals over its recordings: the "
      "filter's position error is at most 1.1 times that of the best bundle adjustment; the "
      "filter's rotation error is smaller than that of the best bundle adjustment; the fastest "
      "bundle adjustment takes more than ten times as long. Does not hold if an interval "
      "contradicts one condition in one scene.",
      "6 min",
      RunEkfVsBundleAdjustment};
}

}  // namespace cairn
