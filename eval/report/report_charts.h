// The charts of a report; private to eval/report.
#ifndef CAIRN_EVAL_REPORT_REPORT_CHARTS_H_
#define CAIRN_EVAL_REPORT_REPORT_CHARTS_H_

#include <string>

#include "eval/evaluation.h"

namespace cairn {

// All return SVG. Bands and bars are 95 % intervals (Wilson). The report has at least one query.

// The share of queries within an error, over the error.
std::string PositionRecallChart(const EvalReport& report);
std::string RotationRecallChart(const EvalReport& report);

// Precision over recall, for each lowest score that answers must have.
std::string PrecisionChart(const EvalReport& report);

// The share of right answers over the confidence that they state.
std::string ConfidenceChart(const EvalReport& report);

// The share of answers whose error is within a multiple of the 68 % radius that they state.
std::string RadiusChart(const EvalReport& report);

// Median and 90th percentile of the times of the stages.
std::string TimesChart(const EvalReport& report);

}  // namespace cairn

#endif  // CAIRN_EVAL_REPORT_REPORT_CHARTS_H_
