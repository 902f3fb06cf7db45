// Measures the loss through wrong gravity, compared with no gravity.
#include <fmt/format.h>

#include <string>
#include <vector>

#include "core/angles.h"
#include "eval/eval_query.h"
#include "lab/experiments/measure/variants.h"
#include "lab/experiments/runs/runs.h"

namespace cairn {
namespace {

constexpr const char* kGiven = "gravity given";
constexpr const char* kAbsent = "no gravity";
// Largest acceptable loss of average precision through wrong gravity, compared with no gravity.
constexpr double kGravityMargin = 0.05;
constexpr double kPhoneErrorDeg = 1.0;

// Returns the world with other priors: position errors of 10 m per axis, gravity errors of
// `gravity_sigma_deg`.
ExperimentWorld WithGravity(ExperimentWorld world, double gravity_sigma_deg, bool with_gravity,
                            uint64_t seed) {
  PriorNoiseOptions noise;
  noise.gravity_sigma_rad = kRadPerDeg * gravity_sigma_deg;
  noise.with_gravity = with_gravity;
  noise.seed = seed;
  AddNoisyPriors(noise, &world.queries);
  return world;
}

// Measures the engine as users run it: unlike BestVariant(), it gives no answer for weak or
// ambiguous poses.
MeasuredVariant Measure(const ExperimentWorld& world, const std::string& method, double x,
                        const ExperimentContext& context) {
  return MeasureVariants(world, {{method, x, LocalizerOptions()}}, context).front();
}

ExperimentOutcome RunWrongGravity(const ExperimentContext& context) {
  const auto world = context.worlds->Get(StandardWorld(context), context.progress);
  const auto errors_deg = context.Pick<std::vector<double>>(
      {kPhoneErrorDeg, 10.0}, {0.25, kPhoneErrorDeg, 2.0, 3.0, 5.0, 10.0, 20.0, 40.0});
  MeasuredVariant absent =
      Measure(WithGravity(*world, 0.0, false, context.seed), kAbsent, 0.0, context);
  std::vector<MeasuredVariant> measured;
  for (const double error_deg : errors_deg) {
    measured.push_back(
        Measure(WithGravity(*world, error_deg, true, context.seed), kGiven, error_deg, context));
  }
  for (const double error_deg : errors_deg) {  // Equal at every error: a line for comparison.
    absent.variant.x = error_deg;
    measured.push_back(absent);
  }

  ExperimentOutcome outcome;
  outcome.parameters = WorldParameters(*world);
  outcome.table = AccuracyTable("gravity_error_deg", measured, absent);
  outcome.figures = {AccuracyFigure("21_wrong_gravity", "Gravity that is off",
                                    "error of gravity, degrees an axis (1 sigma)", measured)};
  outcome.figures[0].log_x = true;
  const MeasuredVariant& phone = At(measured, kGiven, kPhoneErrorDeg);
  std::vector<Verdict> parts;
  std::string costs;
  for (const double error_deg : errors_deg) {
    const Interval gain = ApDifference(At(measured, kGiven, error_deg), absent);
    parts.push_back(JudgeGreater(gain, -kGravityMargin));
    costs += fmt::format("{}{} at {}°", costs.empty() ? "" : ", ", DifferenceText(gain), error_deg);
  }
  outcome.verdict = JudgeAll(parts);
  outcome.sentence = fmt::format(
      "Without gravity, average precision is {}. Wrong gravity changes average precision by {}. "
      "Gravity that is right to {}° takes {:.2f} times the processor time of no gravity.",
      IntervalText(absent.report.average_precision), costs, kPhoneErrorDeg,
      phone.MeanCpuSeconds() / absent.MeanCpuSeconds());
  return outcome;
}

}  // namespace

Experiment WrongGravityExperiment() {
  return {"21_wrong_gravity",
          "Wrong gravity",
          "not in the paper",
          "Compared with no gravity, wrong gravity costs at most 0.05 average precision, however "
          "large its error.",
          "holds if the paired interval of the difference is above -0.05 at every error; does not "
          "hold if it is below -0.05 at one error.",
          "3 min",
          RunWrongGravity};
}

}  // namespace cairn
