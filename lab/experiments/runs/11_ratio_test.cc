// The ratio test against the absolute threshold, on the inverted multi-index.
#include <fmt/format.h>

#include <vector>

#include "lab/experiments/measure/index_variants.h"
#include "lab/experiments/measure/variants.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

constexpr const char* kAbsolute = "absolute threshold";
constexpr const char* kRatio = "ratio test";

std::vector<Variant> MakeVariants(const ExperimentContext& context) {
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
    Variant variant{kRatio, ratio, base};
    variant.options.matching.distance_filter = DistanceFilter::kWordRatio;
    variant.options.matching.max_word_ratio = ratio;
    variants.push_back(variant);
  }
  return variants;
}

ExperimentOutcome Run(const ExperimentContext& context) {
  const auto world = context.worlds->Get(StandardWorld(context), context.progress);
  const auto measured = MeasureVariants(*world, MakeVariants(context), context);
  const MeasuredVariant& absolute = BestOf(measured, kAbsolute);
  const MeasuredVariant& ratio = BestOf(measured, kRatio);
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
      "At its best (quantile {}) the absolute threshold has an average precision of {}, the ratio "
      "test at its best (ratio {}) {}: a difference of {}.",
      absolute.variant.x, IntervalText(absolute.report.average_precision), ratio.variant.x,
      IntervalText(ratio.report.average_precision), DifferenceText(gain));
  return outcome;
}

}  // namespace

Experiment RatioTestExperiment() {
  return {"11_ratio_test",
          "Ratio test against absolute threshold",
          "Figure 12",
          "An absolute threshold serves better than a ratio test against the words of the inverted "
          "multi-index.",
          "holds if the best average precision of the absolute threshold is greater than that of "
          "the ratio test, by a paired interval; does not hold if it is smaller.",
          "1 min",
          Run};
}

}  // namespace cairn
