#include "eval/evaluation_compare.h"

#include <limits>
#include <span>

#include "core/check.h"
#include "eval/evaluation_measures.h"

namespace cairn {
namespace {

constexpr RecallThreshold kHalfMetre = {0.5, 0.08726646259971647};  // 5 degrees.

double Measure(const EvalReport& report, std::span<const size_t> sample, AccuracyMeasure measure) {
  switch (measure) {
    case AccuracyMeasure::kAveragePrecision:
      return AveragePrecisionOf(report.answers, sample);
    case AccuracyMeasure::kRecallAtCorrect:
      return RecallOf(report.answers, sample, kCorrect);
    case AccuracyMeasure::kRecallAtHalfMetre:
      return RecallOf(report.answers, sample, kHalfMetre);
    case AccuracyMeasure::kMedianPositionError:
      return MedianOfLocalized(report.answers, sample, &EvalAnswer::position_error_m);
    case AccuracyMeasure::kMedianRotationError:
      return MedianOfLocalized(report.answers, sample, &EvalAnswer::rotation_error_rad);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

Interval MeasureAccuracy(const EvalReport& report, AccuracyMeasure measure) {
  return Bootstrap(report.answers.size(), [&](std::span<const size_t> sample) {
    return Measure(report, sample, measure);
  });
}

Interval PairedDifference(const EvalReport& a, const EvalReport& b, AccuracyMeasure measure) {
  CAIRN_CHECK(a.answers.size() == b.answers.size(), "answers to the same queries are compared");
  return Bootstrap(a.answers.size(), [&](std::span<const size_t> sample) {
    return Measure(a, sample, measure) - Measure(b, sample, measure);
  });
}

}  // namespace cairn
