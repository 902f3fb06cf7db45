// Variants of the localizer on one world: the sweep that most experiments are.
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
  std::string method;  // A curve of the figure.
  double x = 0.0;      // Where on it.
  LocalizerOptions options;
};

struct MeasuredVariant {
  Variant variant;
  EvalReport report;
  std::vector<double> cpu_seconds;  // Of each query's thread, tiles warm.

  double MeanCpuSeconds() const;
};

// The paper's best variant (section "Best performing and reference method"), which is the engine's
// default, but for the answer: any hypothesis is a response, however weak or ambiguous, as average
// precision ranks all responses by score.
LocalizerOptions BestVariant();

// Asks the world's queries with every variant. Tiles are indexed before the first query. Queries
// run on context.num_threads threads; times are CPU times of the query's own thread.
std::vector<MeasuredVariant> MeasureVariants(const ExperimentWorld& world,
                                             const std::vector<Variant>& variants,
                                             const ExperimentContext& context);

// The variant with most average precision among those of the method; there must be one.
const MeasuredVariant& BestOf(const std::vector<MeasuredVariant>& measured,
                              const std::string& method);
// The variant of the method at x; there must be one.
const MeasuredVariant& At(const std::vector<MeasuredVariant>& measured, const std::string& method,
                          double x);
// a's average precision minus b's, paired.
Interval ApDifference(const MeasuredVariant& a, const MeasuredVariant& b);

// A row a variant: method, x, average precision, recall within 3 m and 10 degrees, median position
// error, each with its interval, CPU time in units of that of `reference` and in ms.
ResultTable AccuracyTable(const std::string& x_name, const std::vector<MeasuredVariant>& measured,
                          const MeasuredVariant& reference);

// Average precision over x, a curve a method, in the order in which methods first occur.
Figure AccuracyFigure(const std::string& name, const std::string& title, const std::string& x_label,
                      const std::vector<MeasuredVariant>& measured);

// What every experiment on one world says about it.
ExperimentParameters WorldParameters(const ExperimentWorld& world);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_MEASURE_VARIANTS_H_
