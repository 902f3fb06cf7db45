// Measures of a sample of answers, drawn by index; private to eval.
#ifndef CAIRN_EVAL_EVALUATION_MEASURES_H_
#define CAIRN_EVAL_EVALUATION_MEASURES_H_

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "eval/evaluation.h"

namespace cairn {

// All: not a number for an empty sample. A sample may name an answer more than once.

// Share of the sample within the threshold.
double RecallOf(const std::vector<EvalAnswer>& answers, std::span<const size_t> sample,
                const RecallThreshold& threshold);

// Median error over the localized answers of the sample; not a number if there are none.
double MedianOfLocalized(const std::vector<EvalAnswer>& answers, std::span<const size_t> sample,
                         double EvalAnswer::*error);

// Score and correctness (kCorrect) of the localized answers of the sample.
std::vector<std::pair<double, bool>> RankedResponses(const std::vector<EvalAnswer>& answers,
                                                     std::span<const size_t> sample);

double AveragePrecisionOf(const std::vector<EvalAnswer>& answers, std::span<const size_t> sample);

}  // namespace cairn

#endif  // CAIRN_EVAL_EVALUATION_MEASURES_H_
