// Measures the RANSAC iterations that voting and covisibility filtering need.
#include <fmt/format.h>

#include <vector>

#include "lab/experiments/measure/variants.h"
#include "lab/experiments/runs/filters.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

std::vector<Variant> IterationVariants(const std::vector<int>& iterations) {
  std::vector<Variant> variants;
  for (const NamedFilter& filter : {kVoting, kVotingFlat, kCovisible}) {
    for (const int count : iterations) {
      Variant variant{filter.name, static_cast<double>(count), BestVariant()};
      variant.options.voting = filter.with_filter(variant.options.voting);
      variant.options.pose.min_iterations = count;  // Exactly this many, whatever the quality.
      variant.options.pose.max_iterations = count;
      variant.options.refinement.mode = RefinementMode::kNever;
      variants.push_back(variant);
    }
  }
  return variants;
}

// Returns how much more covisibility filtering loses with few iterations than voting does.
Interval ExtraLoss(const std::vector<MeasuredVariant>& measured, int few, int many) {
  return PairedContrast({{1.0, &At(measured, kCovisible.name, many).report},
                         {-1.0, &At(measured, kCovisible.name, few).report},
                         {-1.0, &At(measured, kVoting.name, many).report},
                         {1.0, &At(measured, kVoting.name, few).report}},
                        AccuracyMeasure::kAveragePrecision);
}

ExperimentOutcome RunRansacIterations(const ExperimentContext& context) {
  const auto world = context.worlds->Get(StandardWorld(context), context.progress);
  const auto iterations = context.Pick<std::vector<int>>({10, 300}, {10, 30, 100, 300, 1000});
  const auto measured = MeasureVariants(*world, IterationVariants(iterations), context);
  const int few = context.Pick(10, 30);
  const int many = iterations.back();
  const Interval extra_loss = ExtraLoss(measured, few, many);
  const Interval at_many =
      ApDifference(At(measured, kVoting.name, many), At(measured, kCovisible.name, many));

  ExperimentOutcome outcome;
  outcome.parameters = WorldParameters(*world);
  outcome.parameters.emplace_back("refinement", "off");
  outcome.table = AccuracyTable("iterations", measured, At(measured, kVoting.name, many));
  outcome.figures = {AccuracyFigure("12_ransac_iterations", "RANSAC iterations after filtering",
                                    "RANSAC iterations a candidate", measured)};
  outcome.figures[0].log_x = true;
  outcome.verdict = JudgeGreater(extra_loss);
  outcome.sentence = fmt::format(
      "A cut to {} iterations from {} costs covisibility filtering {} more average precision than "
      "voting. With {}, voting is ahead by {}.",
      few, many, DifferenceText(extra_loss), many, DifferenceText(at_many));
  return outcome;
}

}  // namespace

Experiment RansacIterationsExperiment() {
  return {
      "12_ransac_iterations",
      "RANSAC iterations: voting against covisibility",
      "Figure 13",
      "Voting converges with fewer RANSAC iterations than covisibility filtering.",
      "holds if a cut from the most to few iterations costs covisibility filtering more average "
      "precision than voting, by a paired interval; does not hold if the cut costs less.",
      "1 min",
      RunRansacIterations};
}

}  // namespace cairn
