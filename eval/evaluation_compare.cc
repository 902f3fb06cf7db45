#include "eval/evaluation_compare.h"

#include <limits>
#include <span>

#include "core/angles.h"
#include "core/check.h"
#include "eval/evaluation_measures.h"

namespace cairn {
namespace {

constexpr RecallThreshold kHalfMeter = {0.5, 5.0 * kRadPerDeg};

double Measure(const EvalReport& report, std::span<const size_t> sample, AccuracyMeasure measure) {
  switch (measure) {
    case AccuracyMeasure::kAveragePrecision:
      return AveragePrecisionOf(report.answers, sample);
    case AccuracyMeasure::kRecallAtCorrect:
      return RecallOf(report.answers, sample, kCorrect);
    case AccuracyMeasure::kRecallAtHalfMeter:
      return RecallOf(report.answers, sample, kHalfMeter);
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

Interval PairedContrast(const std::vector<ContrastTerm>& terms, AccuracyMeasure measure) {
  CAIRN_CHECK(!terms.empty(), "a contrast needs terms");
  const size_t num_answers = terms.front().report->answers.size();
  for (const ContrastTerm& term : terms) {
    CAIRN_CHECK(term.report->answers.size() == num_answers, "the reports answer the same queries");
  }
  return Bootstrap(num_answers, [&](std::span<const size_t> sample) {
    double sum = 0.0;
    for (const ContrastTerm& term : terms) {
      sum += term.weight * Measure(*term.report, sample, measure);
    }
    return sum;
  });
}

Interval PairedDifference(const EvalReport& a, const EvalReport& b, AccuracyMeasure measure) {
  return PairedContrast({{1.0, &a}, {-1.0, &b}}, measure);
}

Interval MeanPairedDifference(const std::vector<ReportPair>& pairs, AccuracyMeasure measure) {
  const double weight = 1.0 / static_cast<double>(pairs.size());
  std::vector<ContrastTerm> terms;
  for (const auto& [a, b] : pairs) {
    terms.push_back({weight, a});
    terms.push_back({-weight, b});
  }
  return PairedContrast(terms, measure);
}

}  // namespace cairn
