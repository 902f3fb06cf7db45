#include "eval/evaluation_compare.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace cairn {
namespace {

// A report whose answers have these errors, all at score 1, -1 for no answer.
EvalReport ReportWithErrors(const std::vector<double>& position_errors_m) {
  EvalReport report;
  for (const double error_m : position_errors_m) {
    EvalAnswer answer;
    answer.result.localized = error_m >= 0.0;
    answer.result.score = 1.0;
    answer.position_error_m = error_m;
    report.answers.push_back(answer);
  }
  report.num_queries = static_cast<int>(report.answers.size());
  return report;
}

TEST(PrecisionRecallCurve, HasAPointForEachScore) {
  // Five queries; responses 9 right, 8 wrong, 7 right and 7 wrong together.
  const auto curve =
      PrecisionRecallCurve({{7.0, true}, {8.0, false}, {9.0, true}, {7.0, false}}, 5);
  ASSERT_EQ(curve.size(), 3u);
  EXPECT_DOUBLE_EQ(curve[0].score, 9.0);
  EXPECT_DOUBLE_EQ(curve[0].precision, 1.0);
  EXPECT_DOUBLE_EQ(curve[0].recall, 0.2);
  EXPECT_DOUBLE_EQ(curve[1].precision, 0.5);
  EXPECT_DOUBLE_EQ(curve[1].recall, 0.2);
  EXPECT_DOUBLE_EQ(curve[2].precision, 0.5);
  EXPECT_DOUBLE_EQ(curve[2].recall, 0.4);
}

TEST(PrecisionRecallCurve, IsEmptyWithoutResponses) {
  EXPECT_TRUE(PrecisionRecallCurve({}, 3).empty());
}

TEST(MeasureAccuracy, TakesEachMeasure) {
  // Within 0.5 m: 0.4. Within 3 m: 0.4, 2. The median of 0.4, 2, 8 is 2.
  const EvalReport report = ReportWithErrors({0.4, 2.0, 8.0, -1.0});
  EXPECT_DOUBLE_EQ(MeasureAccuracy(report, AccuracyMeasure::kRecallAtCorrect).value, 0.5);
  EXPECT_DOUBLE_EQ(MeasureAccuracy(report, AccuracyMeasure::kRecallAtHalfMeter).value, 0.25);
  EXPECT_DOUBLE_EQ(MeasureAccuracy(report, AccuracyMeasure::kMedianPositionError).value, 2.0);
  EXPECT_DOUBLE_EQ(MeasureAccuracy(report, AccuracyMeasure::kMedianRotationError).value, 0.0);
  // One step of precision 2/3 up to recall 1/2.
  EXPECT_DOUBLE_EQ(MeasureAccuracy(report, AccuracyMeasure::kAveragePrecision).value, 1.0 / 3.0);
}

TEST(PairedDifference, IsExactlyZeroBetweenEqualMethods) {
  const EvalReport report = ReportWithErrors({0.1, 9.0, 0.1, -1.0, 0.2});
  const Interval difference = PairedDifference(report, report, AccuracyMeasure::kAveragePrecision);
  EXPECT_EQ(difference.value, 0.0);
  EXPECT_EQ(difference.low, 0.0);
  EXPECT_EQ(difference.high, 0.0);
}

TEST(PairedDifference, SeesASmallDifferenceThroughHardQueries) {
  // 100 queries, half of them hopeless for both methods; `better` solves 10 more than `worse`.
  std::vector<double> better, worse;
  for (int i = 0; i < 100; ++i) {
    better.push_back(i < 50 ? 0.1 : -1.0);
    worse.push_back(i < 40 ? 0.1 : -1.0);
  }
  const EvalReport a = ReportWithErrors(better), b = ReportWithErrors(worse);
  const Interval difference = PairedDifference(a, b, AccuracyMeasure::kRecallAtCorrect);
  EXPECT_NEAR(difference.value, 0.1, 1e-12);
  // Its standard error is that of a share of 0.1: 0.03; unpaired it would be 0.07.
  EXPECT_NEAR(difference.low, 0.1 - 1.96 * 0.03, 0.02);
  EXPECT_NEAR(difference.high, 0.1 + 1.96 * 0.03, 0.02);
  const Interval reversed = PairedDifference(b, a, AccuracyMeasure::kRecallAtCorrect);
  EXPECT_NEAR(reversed.low, -difference.high, 1e-12);
}

TEST(PairedContrast, IsADifferenceOfDifferences) {
  const EvalReport all = ReportWithErrors({0.1, 0.1, 0.1, 0.1});
  const EvalReport half = ReportWithErrors({0.1, 0.1, -1.0, -1.0});
  const EvalReport none = ReportWithErrors({-1.0, -1.0, -1.0, -1.0});
  // (1 - 1/2) - (1/2 - 0).
  const Interval contrast = PairedContrast(
      {{1.0, &all}, {-1.0, &half}, {-1.0, &half}, {1.0, &none}}, AccuracyMeasure::kRecallAtCorrect);
  EXPECT_NEAR(contrast.value, 0.0, 1e-12);
  EXPECT_LT(contrast.low, 0.0);
  EXPECT_GT(contrast.high, 0.0);
}

// One query of four in the mean, where each pair alone differs by two or by none.
TEST(MeanPairedDifference, IsTheMeanOverPairs) {
  const EvalReport all = ReportWithErrors({0.1, 0.1, 0.1, 0.1});
  const EvalReport half = ReportWithErrors({0.1, 0.1, -1.0, -1.0});
  const Interval mean =
      MeanPairedDifference({{&all, &half}, {&half, &half}}, AccuracyMeasure::kRecallAtCorrect);
  const Interval one = PairedDifference(all, half, AccuracyMeasure::kRecallAtCorrect);
  EXPECT_DOUBLE_EQ(mean.value, 0.25);
  EXPECT_DOUBLE_EQ(mean.low, one.low / 2.0);
  EXPECT_DOUBLE_EQ(mean.high, one.high / 2.0);
}

}  // namespace
}  // namespace cairn
