// Measures the absolute threshold on the descriptor distance over cities and indices.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "lab/experiments/measure/index_variants.h"
#include "lab/experiments/measure/variants.h"
#include "lab/experiments/runs/cities.h"
#include "lab/experiments/runs/runs.h"
#include "storage/codebook/distance_statistics.h"

namespace cairn {
namespace {

constexpr double kThresholdMargin = 0.02;

std::vector<Variant> ThresholdVariants(const std::string& city, ExperimentSize size,
                                       const std::vector<double>& quantiles) {
  std::vector<Variant> variants;
  for (const IndexMethod method : {IndexMethod::kRandomGrids, IndexMethod::kInvertedMultiIndex}) {
    for (const double quantile : quantiles) {
      Variant variant{fmt::format("{}, {}", city, IndexLabel(method)), quantile, BestVariant()};
      variant.options.matching.index = IndexOfMethod(method, size);
      variant.options.matching.distance_quantile = quantile;
      variants.push_back(variant);
    }
  }
  return variants;
}

// Returns the threshold with the highest average precision in the mean over the cities, with random
// grids.
double BestThreshold(const std::vector<std::vector<MeasuredVariant>>& cities,
                     const std::vector<double>& quantiles) {
  const auto sum_at = [&](size_t i) {
    double sum = 0.0;
    for (const auto& measured : cities) {
      sum += measured[i].report.average_precision.value;
    }
    return sum;
  };
  size_t best = 0;
  for (size_t i = 1; i < quantiles.size(); ++i) {
    best = sum_at(i) > sum_at(best) ? i : best;
  }
  return quantiles[best];
}

ExperimentOutcome RunThresholdOverCities(const ExperimentContext& context) {
  const auto quantiles = context.Pick<std::vector<double>>({0.5, 0.9}, {0.5, 0.7, 0.9, 0.95});
  std::vector<std::vector<MeasuredVariant>> cities;
  std::vector<MeasuredVariant> all;
  ExperimentOutcome outcome;
  for (const auto& [name, options] : Cities(context)) {
    const auto world = context.worlds->Get(options, context.progress);
    cities.push_back(
        MeasureVariants(*world, ThresholdVariants(name, context.size, quantiles), context));
    all.insert(all.end(), cities.back().begin(), cities.back().end());
    outcome.parameters.emplace_back(
        name, fmt::format("{}, {} descriptors, {} queries, distance at quantile 0.9: {:.3f}",
                          world->description, world->info.num_descriptors, world->queries.size(),
                          SameLandmarkDistance(*world->store->Snapshot().CurrentCodebook(), 0.9)));
  }
  const double common = BestThreshold(cities, quantiles);
  std::vector<Verdict> verdicts;
  std::string losses;
  for (const auto& measured : cities) {
    const std::string& method = measured.front().variant.method;
    const Interval loss = ApDifference(BestOf(measured, method), At(measured, method, common));
    verdicts.push_back(loss.high <= kThresholdMargin ? Verdict::kHolds
                       : loss.low > kThresholdMargin ? Verdict::kDoesNotHold
                                                     : Verdict::kUndecided);
    losses += fmt::format("{}{}: {}", losses.empty() ? "" : "; ",
                          method.substr(0, method.find(',')), DifferenceText(loss));
  }
  outcome.table = AccuracyTable("quantile", all, all.front());
  outcome.figures = {AccuracyFigure("10_threshold", "Absolute threshold over cities",
                                    "threshold, quantile of same-landmark distances", all)};
  outcome.verdict = JudgeAll(verdicts);
  outcome.sentence = fmt::format(
      "The best threshold on average is the {} quantile. Its loss of average precision against "
      "each city's own best threshold, with random grids: {}.",
      common, losses);
  return outcome;
}

}  // namespace

Experiment ThresholdOverCitiesExperiment() {
  return {"10_threshold_over_cities",
          "One absolute threshold over cities",
          "Figure 11",
          "The best absolute threshold on the descriptor distance is the same in all cities.",
          "holds if the best threshold on average loses at most 0.02 average precision against "
          "each city's own best, by the upper end of the paired interval; does not hold if the "
          "whole interval of one city is above 0.02.",
          "3 min",
          RunThresholdOverCities};
}

}  // namespace cairn
