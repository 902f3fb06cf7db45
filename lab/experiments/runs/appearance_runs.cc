#include "lab/experiments/runs/appearance_runs.h"

#include <fmt/format.h>

namespace cairn {
namespace {

constexpr AppearanceKind kKinds[] = {AppearanceKind::kKMeans, AppearanceKind::kKMedoids,
                                     AppearanceKind::kRandom};
constexpr int64_t kQuickLandmarks = 2'000, kFullLandmarks = 10'000;

IngestOptions BaseIngest(AppearanceKind kind, const ExperimentContext& context) {
  IngestOptions ingest;
  ingest.selection.kind = LandmarkSelectionKind::kCoverage;
  ingest.selection.max_landmarks = context.Pick(kQuickLandmarks, kFullLandmarks);
  ingest.appearance.kind = kind;
  return ingest;
}

}  // namespace

const char* AppearanceLabel(AppearanceKind kind) {
  switch (kind) {
    case AppearanceKind::kKMeans:
      return "k-means";
    case AppearanceKind::kKMedoids:
      return "k-medoids";
    case AppearanceKind::kRandom:
      return "random";
  }
  return "random";
}

IngestVariant FixedCountVariant(const std::string& method, AppearanceKind kind, int count,
                                const ExperimentContext& context) {
  IngestVariant variant{method, static_cast<double>(count), BaseIngest(kind, context)};
  variant.ingest.appearance.count = count;
  return variant;
}

IngestVariant RatioVariant(const std::string& method, AppearanceKind kind, double ratio,
                           const ExperimentContext& context) {
  IngestVariant variant{method, ratio, BaseIngest(kind, context)};
  variant.ingest.appearance.ratio = ratio;
  return variant;
}

ExperimentOutcome CompareKinds(const ExperimentContext& context, const std::string& name,
                               const std::string& title, const std::string& knob_name,
                               const std::vector<double>& knobs,
                               IngestVariant (*make)(const std::string&, AppearanceKind, double,
                                                     const ExperimentContext&)) {
  std::vector<IngestVariant> variants;
  for (const AppearanceKind kind : kKinds) {
    for (const double knob : knobs) {
      variants.push_back(make(AppearanceLabel(kind), kind, knob, context));
    }
  }
  const ExperimentWorldOptions world = MemoryWorld(context);
  const auto measured = MeasureIngest(world, variants, context);
  const std::string means = AppearanceLabel(AppearanceKind::kKMeans);
  const Interval to_medoids =
      MeanApDifference(measured, means, AppearanceLabel(AppearanceKind::kKMedoids), knobs);
  const Interval to_random =
      MeanApDifference(measured, means, AppearanceLabel(AppearanceKind::kRandom), knobs);
  const MeasuredIngest &least = At(measured, means, knobs.front()),
                       &most = At(measured, means, knobs.back());
  ExperimentOutcome outcome;
  outcome.parameters = MemoryParameters(world, measured);
  outcome.parameters.emplace_back("landmark budget a tile",
                                  fmt::format("{}", context.Pick(kQuickLandmarks, kFullLandmarks)));
  outcome.table = MemoryTable(knob_name, measured);
  outcome.figures = {MemoryFigure(name, title, measured)};
  outcome.verdict = JudgeAll({JudgeGreater(to_medoids), JudgeGreater(to_random)});
  outcome.sentence = fmt::format(
      "In the mean, k-means differs by {} average precision from k-medoids and by {} from random "
      "choice. A reduction from {:.2f} to {:.2f} MB per tile ({:.0f} % less) costs k-means {}.",
      DifferenceText(to_medoids), DifferenceText(to_random), most.MegabytesPerTile(),
      least.MegabytesPerTile(), 100.0 * (1.0 - least.MegabytesPerTile() / most.MegabytesPerTile()),
      DifferenceText(ApDifference(most.answers, least.answers)));
  return outcome;
}

}  // namespace cairn
