// Compares k nearest neighbors with and without a threshold on the distance.
#include <fmt/format.h>

#include "lab/experiments/measure/variants.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

constexpr const char* kRange = "range search";
constexpr const char* kPlainSearch = "plain kNN";

ExperimentOutcome RunNeighbors(const ExperimentContext& context) {
  const auto world = context.worlds->Get(StandardWorld(context), context.progress);
  const std::vector<int> neighbors =
      context.Pick<std::vector<int>>({1, 4, 8}, {1, 2, 4, 8, 16, 32});
  std::vector<Variant> variants;
  for (const char* method : {kRange, kPlainSearch}) {
    for (const int k : neighbors) {
      Variant variant{method, static_cast<double>(k), BestVariant()};
      variant.options.matching.max_neighbors = k;
      variant.options.matching.distance_filter =
          method == kRange ? DistanceFilter::kAbsolute : DistanceFilter::kNone;
      variants.push_back(variant);
    }
  }
  const auto measured = MeasureVariants(*world, variants, context);
  const MeasuredVariant& at_four = At(measured, kRange, kPaperNeighbors);
  const Interval to_one = ApDifference(at_four, At(measured, kRange, neighbors.front()));
  const Interval to_many = ApDifference(at_four, At(measured, kRange, neighbors.back()));
  const Interval to_plain = ApDifference(at_four, At(measured, kPlainSearch, kPaperNeighbors));

  ExperimentOutcome outcome;
  outcome.parameters = WorldParameters(*world);
  outcome.table = AccuracyTable("neighbors", measured, at_four);
  outcome.figures = {
      AccuracyFigure("09_neighbors", "Neighbors per keypoint", "neighbors k", measured)};
  outcome.figures[0].log_x = true;
  outcome.verdict = JudgeAll({JudgeGreater(to_one), JudgeGreater(to_many), JudgeGreater(to_plain)});
  outcome.sentence = fmt::format(
      "With a threshold, average precision at k = {} is {}. The difference is {} to k = {}, {} to "
      "k = {}, and {} to plain kNN at k = {}.",
      kPaperNeighbors, IntervalText(at_four.report.average_precision), DifferenceText(to_one),
      neighbors.front(), DifferenceText(to_many), neighbors.back(), DifferenceText(to_plain),
      kPaperNeighbors);
  return outcome;
}

}  // namespace

Experiment NeighborsExperiment() {
  return {"09_neighbors",
          "k neighbors with and without a threshold",
          "Figure 10",
          "Performance is highest at k = 4 neighbors per keypoint, and an absolute threshold on "
          "the descriptor distance improves it.",
          "holds if average precision with the threshold at k = 4 is higher than at the smallest "
          "k, at the largest k, and without the threshold, each by a paired interval; does not "
          "hold if it is lower than one of these.",
          "1 min",
          RunNeighbors};
}

}  // namespace cairn
