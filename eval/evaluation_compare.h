// Compares two methods on the same queries and tells a real difference from chance.
#ifndef CAIRN_EVAL_EVALUATION_COMPARE_H_
#define CAIRN_EVAL_EVALUATION_COMPARE_H_

#include <utility>
#include <vector>

#include "eval/evaluation.h"

namespace cairn {

// The measures by which two reports are compared.
enum class AccuracyMeasure {
  kAveragePrecision,
  kRecallAtCorrect,      // Share of queries answered within 3 m and 10 degrees.
  kRecallAtHalfMeter,    // Share of queries answered within 0.5 m and 5 degrees.
  kMedianPositionError,  // Meters, over the localized queries of each report; smaller is better.
  kMedianRotationError,  // Radians.
};

// The measure of one report with its interval.
Interval MeasureAccuracy(const EvalReport& report, AccuracyMeasure measure);

// The measure of `a` minus the measure of `b`, with a paired 95 % bootstrap interval. Both measures
// use the same drawn queries, so the difficulty of a query cancels. If the interval excludes zero,
// the choice of queries does not explain the difference. Answers i of both reports must be to the
// same query.
Interval PairedDifference(const EvalReport& a, const EvalReport& b, AccuracyMeasure measure);

// A weighted sum of measures of reports on the same queries, with its paired interval. A difference
// of differences is one example.
struct ContrastTerm {
  double weight = 1.0;
  const EvalReport* report = nullptr;
};
Interval PairedContrast(const std::vector<ContrastTerm>& terms, AccuracyMeasure measure);

// The mean of PairedDifference over pairs of reports, all on the same queries. `pairs` must not be
// empty.
using ReportPair = std::pair<const EvalReport*, const EvalReport*>;
Interval MeanPairedDifference(const std::vector<ReportPair>& pairs, AccuracyMeasure measure);

}  // namespace cairn

#endif  // CAIRN_EVAL_EVALUATION_COMPARE_H_
