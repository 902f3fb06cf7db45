// Smoothness of the fused trajectory.
#include <fmt/format.h>

#include <string>
#include <vector>

#include "eval/experiments/runs/fusion_scenes.h"
#include "eval/experiments/runs/runs.h"

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

ResultTable MakeTable(const std::vector<FusionScene>& scenes) {
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

ExperimentOutcome Run(const ExperimentContext& context) {
  const std::vector<FusionScene> scenes = RunFusionScenes(context, fusion::PaperVariants());
  ExperimentOutcome outcome;
  outcome.parameters = FusionParameters(context);
  outcome.table = MakeTable(scenes);
  outcome.figures = {SceneFigure("17_smoothness", "Change of the position error between frames",
                                 "change from frame to frame, cm (root mean square)", scenes,
                                 ChangeCm)};
  std::vector<Verdict> verdicts;
  for (const FusionScene& scene : scenes) {
    const size_t smoothest = BestRival(scene, ChangeCm);
    const Interval ratio = RatioOver(scene, kFilter, smoothest, ChangeCm);
    verdicts.push_back(JudgeSmaller(ratio, 1.0));
    outcome.sentence += fmt::format(
        "{}In the {}, the filter's position error changes from frame to frame by {} times that of "
        "the smoothest bundle adjustment ({}).",
        outcome.sentence.empty() ? "" : " ", scene.name, IntervalText(ratio, 2),
        scene.methods[smoothest]);
  }
  outcome.verdict = JudgeAll(verdicts);
  return outcome;
}

}  // namespace

Experiment SmoothnessExperiment() {
  return {"17_smoothness",
          "Smoothness of the fused trajectory",
          "Figure 17",
          "The filter's trajectory is significantly smoother than that of bundle adjustment in a "
          "sliding window.",
          "holds if in every scene, by intervals over its recordings, the filter's position error "
          "changes less from frame to frame than that of the smoothest bundle adjustment; does not "
          "hold if it surely changes more in one.",
          "6 min",
          Run};
}

}  // namespace cairn
