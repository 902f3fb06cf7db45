// Compares a fixed number and a ratio of descriptors at about the same memory.
#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "lab/experiments/runs/appearance_runs.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

constexpr double kRatioMargin = 0.03;
constexpr const char* kFixed = "fixed number";
constexpr const char* kByRatio = "ratio";

// Returns the fixed number whose map has the nearest size.
const MeasuredIngest& NearestInSize(const std::vector<MeasuredIngest>& measured,
                                    const MeasuredIngest& to) {
  const MeasuredIngest* nearest = nullptr;
  for (const MeasuredIngest& candidate : measured) {
    if (candidate.variant.method == kFixed &&
        (nearest == nullptr || std::abs(candidate.MegabytesPerTile() - to.MegabytesPerTile()) <
                                   std::abs(nearest->MegabytesPerTile() - to.MegabytesPerTile()))) {
      nearest = &candidate;
    }
  }
  return *nearest;
}

ExperimentOutcome RunFixedVsRatio(const ExperimentContext& context) {
  std::vector<IngestVariant> variants;
  for (const int count : context.Pick<std::vector<int>>({1, 3}, {1, 2, 3, 4})) {
    variants.push_back(FixedCountVariant(kFixed, AppearanceKind::kKMeans, count, context));
  }
  for (const double ratio : context.Pick<std::vector<double>>({0.1, 0.5}, {0.1, 0.25, 0.5})) {
    variants.push_back(RatioVariant(kByRatio, AppearanceKind::kKMeans, ratio, context));
  }
  const ExperimentWorldOptions world = MemoryWorld(context);
  const auto measured = MeasureIngest(world, variants, context);
  std::vector<Verdict> verdicts;
  std::string differences;
  for (const MeasuredIngest& ratio : measured) {
    if (ratio.variant.method != kByRatio) {
      continue;
    }
    const MeasuredIngest& fixed = NearestInSize(measured, ratio);
    const Interval difference = ApDifference(ratio.answers, fixed.answers);
    verdicts.push_back(JudgeEqual(difference, kRatioMargin));
    differences +=
        fmt::format("{}ratio {} ({:.2f} MB) against {:.0f} descriptors ({:.2f} MB) {}",
                    differences.empty() ? "" : "; ", ratio.variant.knob, ratio.MegabytesPerTile(),
                    fixed.variant.knob, fixed.MegabytesPerTile(), DifferenceText(difference));
  }
  ExperimentOutcome outcome;
  outcome.parameters = MemoryParameters(world, measured);
  outcome.table = MemoryTable("knob", measured);
  outcome.figures = {MemoryFigure("04_fixed_vs_ratio", "Fixed number and ratio", measured)};
  outcome.verdict = JudgeAll(verdicts);
  outcome.sentence = "Average precision, maps of nearest size: " + differences + ".";
  return outcome;
}

}  // namespace

Experiment FixedVsRatioExperiment() {
  return {"04_fixed_vs_ratio",
          "Fixed number against ratio of descriptors",
          "Figure 5",
          "For most operating points, a fixed number and a ratio of descriptors differ only "
          "marginally.",
          "holds if every ratio is within 0.03 average precision of the fixed number whose map has "
          "the nearest size, by paired intervals; does not hold if the whole interval of one ratio "
          "is outside.",
          "7 min",
          RunFixedVsRatio};
}

}  // namespace cairn
