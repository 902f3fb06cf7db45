// Measures of a sample of answers, drawn by index; private to eval.
#ifndef CAIRN_EVAL_EVALUATION_MEASURES_H_
#define CAIRN_EVAL_EVALUATION_MEASURES_H_

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "eval/evaluation.h"

namespace cairn {

// All functions return NaN for an empty sample. A sample may contain an index more than once.

// The share of the sample within the threshold.
double RecallOf(const std::vector<EvalAnswer>& answers, std::span<const size_t> sample,
                const RecallThreshold& threshold);

// The median error over the localized answers of the sample; NaN if there are none.
double MedianOfLocalized(const std::vector<EvalAnswer>& answers, std::span<const size_t> sample,
                         double EvalAnswer::*error);

// Score and correctness (within kCorrect) of the localized answers of the sample.
std::vector<std::pair<double, bool>> RankedResponses(const std::vector<EvalAnswer>& answers,
                                                     std::span<const size_t> sample);

double AveragePrecisionOf(const std::vector<EvalAnswer>& answers, std::span<const size_t> sample);

}  // namespace cairn

#endif  // CAIRN_EVAL_EVALUATION_MEASURES_H_
