// Measures variants of the localizer on one world. Most experiments are such sweeps.
#ifndef CAIRN_LAB_EXPERIMENTS_MEASURE_VARIANTS_H_
#define CAIRN_LAB_EXPERIMENTS_MEASURE_VARIANTS_H_

#include <string>
#include <vector>

#include "engine/localizer_options.h"
#include "eval/evaluation.h"
#include "eval/evaluation_compare.h"
#include "lab/experiments/experiment.h"

namespace cairn {

struct Variant {
  std::string method;  // The figure's curve.
  double x = 0.0;      // Position on the curve.
  LocalizerOptions options;
};

struct MeasuredVariant {
  Variant variant;
  EvalReport report;
  std::vector<double> cpu_seconds;  // CPU time of each query's thread, with warm tiles.

  double MeanCpuSeconds() const;
};

// Returns the paper's best variant (section "Best performing and reference method"). It equals the
// engine's default except for the answer: every hypothesis is a response, however weak or
// ambiguous, because average precision ranks all responses by score.
LocalizerOptions BestVariant();

// Runs the world's queries with every variant. All tiles are indexed before the first query.
// Queries run on context.num_threads threads; times are CPU times of the query's own thread.
std::vector<MeasuredVariant> MeasureVariants(const ExperimentWorld& world,
                                             const std::vector<Variant>& variants,
                                             const ExperimentContext& context);

// Returns the method's variant with the highest average precision; there must be one.
const MeasuredVariant& BestOf(const std::vector<MeasuredVariant>& measured,
                              const std::string& method);
// Returns the method's variant at x; there must be one.
const MeasuredVariant& At(const std::vector<MeasuredVariant>& measured, const std::string& method,
                          double x);
// Returns the average precision of `a` minus that of `b`, paired.
Interval ApDifference(const MeasuredVariant& a, const MeasuredVariant& b);

// One row per variant: method, x, average precision, recall within 3 m and 10 degrees, median
// position error, each with its interval; CPU time relative to `reference` and in ms.
ResultTable AccuracyTable(const std::string& x_name, const std::vector<MeasuredVariant>& measured,
                          const MeasuredVariant& reference);

// Average precision over x. One curve per method, in the order of the methods' first variants.
Figure AccuracyFigure(const std::string& name, const std::string& title, const std::string& x_label,
                      const std::vector<MeasuredVariant>& measured);

// Returns the parameters that every experiment on one world reports.
ExperimentParameters WorldParameters(const ExperimentWorld& world);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_MEASURE_VARIANTS_H_
