// Compares the ratio test with the absolute threshold on the inverted multi-index.
#include <fmt/format.h>

#include <vector>

#include "lab/experiments/measure/index_variants.h"
#include "lab/experiments/measure/variants.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

constexpr const char* kAbsolute = "absolute threshold";
constexpr const char* kRatioTest = "ratio test";

std::vector<Variant> RatioTestVariants(const ExperimentContext& context) {
  LocalizerOptions base = BestVariant();
  base.matching.index = IndexOfMethod(IndexMethod::kInvertedMultiIndex, context.size);
  base.matching.index.num_reference_words = DefaultsAt(context.size).multi_index.num_words;
  std::vector<Variant> variants;
  for (const double quantile :
       context.Pick<std::vector<double>>({0.5, 0.9}, {0.5, 0.7, 0.9, 0.95})) {
    Variant variant{kAbsolute, quantile, base};
    variant.options.matching.distance_quantile = quantile;
    variants.push_back(variant);
  }
  for (const double ratio :
       context.Pick<std::vector<double>>({0.9, 1.5}, {0.7, 0.9, 1.1, 1.3, 1.6})) {
    Variant variant{kRatioTest, ratio, base};
    variant.options.matching.distance_filter = DistanceFilter::kWordRatio;
    variant.options.matching.max_word_ratio = ratio;
    variants.push_back(variant);
  }
  return variants;
}

ExperimentOutcome RunRatioTest(const ExperimentContext& context) {
  const auto world = context.worlds->Get(StandardWorld(context), context.progress);
  const auto measured = MeasureVariants(*world, RatioTestVariants(context), context);
  const MeasuredVariant& absolute = BestOf(measured, kAbsolute);
  const MeasuredVariant& ratio = BestOf(measured, kRatioTest);
  const Interval gain = ApDifference(absolute, ratio);
  ExperimentOutcome outcome;
  outcome.parameters = WorldParameters(*world);
  outcome.table = AccuracyTable("threshold", measured, absolute);
  outcome.figures = {AccuracyFigure("11_ratio_test", "Absolute threshold and ratio test",
                                    "quantile of same-landmark distances, or ratio to the nearest "
                                    "word",
                                    measured)};
  outcome.verdict = JudgeGreater(gain);
  outcome.sentence = fmt::format(
      "The absolute threshold at its best (quantile {}) has an average precision of {}. The ratio "
      "test at its best (ratio {}) has {}. The difference is {}.",
      absolute.variant.x, IntervalText(absolute.report.average_precision), ratio.variant.x,
      IntervalText(ratio.report.average_precision), DifferenceText(gain));
  return outcome;
}

}  // namespace

Experiment RatioTestExperiment() {
  return {"11_ratio_test",
          "Ratio test against absolute threshold",
          "Figure 12",
          "With the inverted multi-index, an absolute threshold gives better answers than a ratio "
          "test against the words.",
          "holds if the absolute threshold reaches a higher average precision than the ratio test, "
          "by a paired interval; does not hold if it reaches a lower one.",
          "1 min",
          RunRatioTest};
}

}  // namespace cairn
