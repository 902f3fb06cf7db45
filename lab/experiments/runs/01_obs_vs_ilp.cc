// Compares landmark selection by observation count and by integer programming, over memory.
#include <fmt/format.h>

#include <string>
#include <vector>

#include "lab/experiments/runs/memory_sweep.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

constexpr const char* kObservations = "observation count";
constexpr const char* kProgram = "integer program";

std::vector<IngestVariant> SelectionVariants(const std::vector<double>& budgets) {
  std::vector<IngestVariant> variants;
  for (const char* method : {kObservations, kProgram}) {
    for (const double budget : budgets) {
      IngestVariant variant{method, budget, {}};
      LandmarkSelectionOptions& selection = variant.ingest.selection;
      selection.max_descriptors = static_cast<int64_t>(budget);
      selection.kind = method == kProgram ? LandmarkSelectionKind::kCoverage
                                          : LandmarkSelectionKind::kObservationCount;
      variants.push_back(variant);
    }
  }
  return variants;
}

ExperimentOutcome RunObsVsIlp(const ExperimentContext& context) {
  const ExperimentWorldOptions world = MemoryWorld(context);
  const auto budgets =
      context.Pick<std::vector<double>>({1'000, 4'000}, {4'000, 8'000, 16'000, 32'000, 64'000});
  const auto measured = MeasureIngest(world, SelectionVariants(budgets), context);
  const Interval gain = MeanApDifference(measured, kProgram, kObservations, budgets);
  std::string gains;
  for (const double budget : budgets) {
    const Interval one = MeanApDifference(measured, kProgram, kObservations, {budget});
    gains += fmt::format("{}{} at {:.0f}", gains.empty() ? "" : ", ", DifferenceText(one), budget);
  }
  ExperimentOutcome outcome;
  outcome.parameters = MemoryParameters(world, measured);
  outcome.table = MemoryTable("descriptor_budget", measured);
  outcome.figures = {MemoryFigure("01_obs_vs_ilp", "Selection of landmarks", measured)};
  outcome.figures[0].log_x = true;
  outcome.verdict = JudgeGreater(gain);
  outcome.sentence = fmt::format(
      "In the mean over the budgets of descriptors per tile, the integer program changes average "
      "precision by {} against the observation count with the same budget ({}).",
      DifferenceText(gain), gains);
  return outcome;
}

}  // namespace

Experiment ObsVsIlpExperiment() {
  return {
      "01_obs_vs_ilp",
      "Observation count against integer programming",
      "Figure 2",
      "For the same memory, landmarks that integer programming chooses give better answers than "
      "landmarks chosen by their number of observations.",
      "holds if the difference of average precision, in the mean over equal budgets of "
      "descriptors, is positive by a paired interval; does not hold if the difference is negative.",
      "9 min",
      RunObsVsIlp};
}

}  // namespace cairn
