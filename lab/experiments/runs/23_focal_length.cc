// Measures the loss through a wrong or unknown focal length.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "eval/stated_focal.h"
#include "lab/experiments/measure/variants.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

constexpr const char* kKept = "kept as it is stated";
constexpr const char* kTrusted = "stated";
constexpr const char* kUncertain = "stated, with its error as standard deviation";
constexpr const char* kUnknown = "unknown";
// Largest acceptable loss, as a share of the average precision with the right focal length.
constexpr double kMaxLoss = 0.05;
// Assumed error of a focal length that states none.
constexpr double kMinSigma = 0.01;

// Measures the engine as users run it: it gives no answer for weak and ambiguous poses.
MeasuredVariant Measure(ExperimentWorld world, const StatedFocalOptions& focal,
                        const std::string& method, double error_percent,
                        const ExperimentContext& context) {
  StateFocalLengths(focal, &world.queries);
  return MeasureVariants(world, {{method, error_percent, LocalizerOptions()}}, context).front();
}

std::vector<MeasuredVariant> MeasureAll(const ExperimentWorld& world,
                                        const std::vector<double>& errors_percent,
                                        const ExperimentContext& context) {
  std::vector<MeasuredVariant> measured;
  const auto measure = [&](const char* method, double error_percent, StatedFocalOptions focal) {
    focal.seed = context.seed;
    measured.push_back(Measure(world, focal, method, error_percent, context));
  };
  for (const double percent : errors_percent) {
    const double error = 0.01 * percent;
    measure(kKept, percent, {.error = error, .sigma = FocalPrior::kMinLogSigma});
    measure(kTrusted, percent, {.error = error});
    measure(kUncertain, percent, {.error = error, .sigma = std::max(kMinSigma, error)});
  }
  measure(kUnknown, 0.0, {.withheld = true});
  for (const double percent : errors_percent) {  // Equal at every error: a line.
    if (percent > 0.0) {
      measured.push_back(At(measured, kUnknown, 0.0));
      measured.back().variant.x = percent;
    }
  }
  return measured;
}

ExperimentOutcome RunFocalLength(const ExperimentContext& context) {
  const auto world = context.worlds->Get(StandardWorld(context), context.progress);
  const auto errors_percent =
      context.Pick<std::vector<double>>({0.0, 10.0}, {0.0, 2.0, 5.0, 10.0, 20.0});
  const std::vector<MeasuredVariant> measured = MeasureAll(*world, errors_percent, context);
  const MeasuredVariant& right = At(measured, kTrusted, 0.0);
  const MeasuredVariant& unknown = At(measured, kUnknown, 0.0);

  ExperimentOutcome outcome;
  outcome.parameters = WorldParameters(*world);
  outcome.table = AccuracyTable("focal_error_percent", measured, right);
  outcome.figures = {AccuracyFigure("23_focal_length", "A focal length that is off",
                                    "error of the stated focal length, %", measured)};
  const double margin = kMaxLoss * right.report.average_precision.value;
  std::vector<Verdict> parts = {JudgeGreater(ApDifference(unknown, right), -margin)};
  std::string costs;
  for (const double percent : errors_percent) {
    const Interval of_uncertain = ApDifference(At(measured, kUncertain, percent), right);
    parts.push_back(JudgeGreater(of_uncertain, -margin));
    costs += fmt::format("{}{} at {} % (kept: {})", costs.empty() ? "" : ", ",
                         DifferenceText(of_uncertain), percent,
                         DifferenceText(ApDifference(At(measured, kKept, percent), right)));
  }
  outcome.verdict = JudgeAll(parts);
  outcome.sentence = fmt::format(
      "With the right focal length, average precision is {}. A wrong focal length that states its "
      "error changes average precision by {}. An unknown camera changes it by {} and takes {:.1f} "
      "times the processor time.",
      IntervalText(right.report.average_precision), costs,
      DifferenceText(ApDifference(unknown, right)),
      unknown.MeanCpuSeconds() / right.MeanCpuSeconds());
  return outcome;
}

}  // namespace

Experiment FocalLengthExperiment() {
  return {"23_focal_length",
          "A wrong or unknown focal length",
          "not in the paper",
          "A query that states the error of its focal length, or that the focal length is unknown, "
          "keeps 0.95 of the average precision that the right focal length gives.",
          "holds if the paired intervals of the differences are above -0.05 times that average "
          "precision, for an unknown camera and at every error; does not hold if one interval is "
          "below.",
          "6 min",
          RunFocalLength};
}

}  // namespace cairn
