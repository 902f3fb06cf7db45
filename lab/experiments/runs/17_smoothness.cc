// Measures the smoothness of the fused trajectory.
#include <fmt/format.h>

#include <string>
#include <vector>

#include "lab/experiments/runs/fusion_scenes.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

double ChangeCm(const fusion::MethodResult& result) { return 1e2 * result.position_change_m.rms; }
double ChangeP95Cm(const fusion::MethodResult& result) {
  return 1e2 * result.position_change_m.percentile_95;
}
double MostChangeCm(const fusion::MethodResult& result) {
  return 1e2 * result.position_change_m.maximum;
}
double TurnMrad(const fusion::MethodResult& result) { return 1e3 * result.rotation_change_rad.rms; }

ResultTable SmoothnessTable(const std::vector<FusionScene>& scenes) {
  std::vector<Column> columns = {{"scene"}, {"method"}};
  AddIntervalColumns("position_change_cm", &columns);
  columns.push_back({"95_percent_cm"});
  columns.push_back({"most_cm"});
  AddIntervalColumns("rotation_change_mrad", &columns);
  ResultTable table(std::move(columns));
  for (const FusionScene& scene : scenes) {
    for (size_t method = 0; method < scene.methods.size(); ++method) {
      std::vector<Cell> row = {scene.name, scene.methods[method]};
      AddIntervalCells(MeanOver(scene, method, ChangeCm), &row);
      row.emplace_back(MeanOver(scene, method, ChangeP95Cm).value);
      row.emplace_back(MeanOver(scene, method, MostChangeCm).value);
      AddIntervalCells(MeanOver(scene, method, TurnMrad), &row);
      table.AddRow(std::move(row));
    }
  }
  return table;
}

// Judges one scene and appends the reason to `sentence`.
Verdict JudgeSmoothness(const FusionScene& scene, std::string* sentence) {
  const size_t smoothest = BestRival(scene, ChangeCm);
  const size_t smoothest_steady = BestRival(scene, ChangeCm, true);
  const Interval shown = RatioOver(scene, kSteadyFilter, smoothest, ChangeCm);
  *sentence += fmt::format(
      "{}{}: the position error of the filter's pose for displays changes from frame to frame by "
      "{} times as much as that of the smoothest bundle adjustment ({}), and by {} times as much "
      "as that of the smoothest bundle adjustment with the same smoothing ({}). The position error "
      "of the filter's own estimate changes by {} times as much as that of {}.",
      sentence->empty() ? "" : " ", scene.name, IntervalText(shown, 2), scene.methods[smoothest],
      IntervalText(RatioOver(scene, kSteadyFilter, smoothest_steady, ChangeCm), 2),
      scene.methods[smoothest_steady],
      IntervalText(RatioOver(scene, kFilter, smoothest, ChangeCm), 2), scene.methods[smoothest]);
  return JudgeSmaller(shown, 1.0);
}

ExperimentOutcome RunSmoothness(const ExperimentContext& context) {
  const std::vector<FusionScene> scenes = RunFusionScenes(context, fusion::PaperVariants(), true);
  ExperimentOutcome outcome;
  outcome.parameters = FusionParameters(context);
  outcome.table = SmoothnessTable(scenes);
  outcome.figures = {SceneFigure("17_smoothness", "Change of the position error between frames",
                                 "change from frame to frame, cm (root mean square)", scenes,
                                 ChangeCm)};
  outcome.verdict = JudgeScenes(scenes, JudgeSmoothness, &outcome.sentence);
  return outcome;
}

}  // namespace

Experiment SmoothnessExperiment() {
  return {
      "17_smoothness",
      "Smoothness of the fused trajectory",
      "Figure 17",
      "The filter's trajectory is significantly smoother than the trajectory of bundle adjustment "
      "in a sliding window.",
      "holds if in every scene, by intervals over its recordings, the position error of the "
      "filter's pose for displays changes less from frame to frame than that of the smoothest "
      "bundle adjustment; does not hold if it changes more in one scene. The verdict does not use "
      "the filter's own estimate and the smoothed bundle adjustments, which are also stated.",
      "6 min",
      RunSmoothness};
}

}  // namespace cairn
