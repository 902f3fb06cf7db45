// Two methods on the same queries: is one better, or was it luck?
#ifndef CAIRN_EVAL_EVALUATION_COMPARE_H_
#define CAIRN_EVAL_EVALUATION_COMPARE_H_

#include <utility>
#include <vector>

#include "eval/evaluation.h"

namespace cairn {

// What two reports are compared by.
enum class AccuracyMeasure {
  kAveragePrecision,
  kRecallAtCorrect,      // Share of queries answered within 3 m and 10 degrees.
  kRecallAtHalfMetre,    // Within 0.5 m and 5 degrees.
  kMedianPositionError,  // Metres, over the localized queries of each; smaller is better.
  kMedianRotationError,  // Radians.
};

// The measure of one report, with its interval.
Interval MeasureAccuracy(const EvalReport& report, AccuracyMeasure measure);

// The measure of `a` minus that of `b`, with a paired 95 % bootstrap interval: both are measured on
// the same drawn queries, so that what makes a query hard for both cancels. An interval without
// zero tells a difference from the luck of the queries. Answer i of both must be to the same query.
Interval PairedDifference(const EvalReport& a, const EvalReport& b, AccuracyMeasure measure);

// The sum of weight times measure over reports on the same queries, with its paired interval: a
// difference of differences, say.
struct ContrastTerm {
  double weight = 1.0;
  const EvalReport* report = nullptr;
};
Interval PairedContrast(const std::vector<ContrastTerm>& terms, AccuracyMeasure measure);

// The mean of PairedDifference over pairs of reports, all on the same queries; there must be some.
using ReportPair = std::pair<const EvalReport*, const EvalReport*>;
Interval MeanPairedDifference(const std::vector<ReportPair>& pairs, AccuracyMeasure measure);

}  // namespace cairn

#endif  // CAIRN_EVAL_EVALUATION_COMPARE_H_
