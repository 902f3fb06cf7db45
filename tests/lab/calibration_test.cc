#include "lab/experiments/measure/calibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/error.h"

namespace cairn {
namespace {

// Samples of a world where the confidence is the logistic of slope * log(score) + offset and errors
// are `factor` times as large as the covariance predicts.
std::vector<CalibrationSample> MakeSamples(int num_samples, double slope, double offset,
                                           double factor, uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::normal_distribution<double> normal;
  std::vector<CalibrationSample> samples;
  for (int i = 0; i < num_samples; ++i) {
    CalibrationSample sample;
    sample.score = 8.0 * std::exp(2.0 * unit(generator));
    const double logit = slope * std::log(sample.score) + offset;
    sample.correct = unit(generator) < 1.0 / (1.0 + std::exp(-logit));
    sample.predicted_position_m = 0.02 + 0.2 * unit(generator);
    sample.predicted_rotation_rad = 0.1 * sample.predicted_position_m;
    // 68 % of |normal| is below 0.9945.
    sample.position_error_m =
        factor * sample.predicted_position_m * std::abs(normal(generator)) / 0.9945;
    sample.rotation_error_rad =
        2.0 * factor * sample.predicted_rotation_rad * std::abs(normal(generator)) / 0.9945;
    samples.push_back(sample);
  }
  return samples;
}

TEST(FitCalibration, RecoversTheTruth) {
  const ScoreCalibration fit = FitCalibration(MakeSamples(20'000, 2.5, -6.0, 1.7, 3));
  EXPECT_NEAR(fit.confidence_slope, 2.5, 0.15);
  EXPECT_NEAR(fit.confidence_offset, -6.0, 0.4);
  EXPECT_NEAR(fit.position_accuracy_factor, 1.7, 0.05);
  EXPECT_NEAR(fit.rotation_accuracy_factor, 3.4, 0.08);
}

TEST(FitCalibration, LeavesOutWhatTheMapAdds) {
  std::vector<CalibrationSample> samples = MakeSamples(20'000, 2.5, -6.0, 1.7, 11);
  // Independent of what the matches predict: 68 % of |normal| is below 0.9945.
  std::mt19937_64 generator(12);
  std::normal_distribution<double> map_error(0.0, 0.3 / 0.9945);
  for (CalibrationSample& sample : samples) {
    const double own = std::bernoulli_distribution(0.5)(generator) ? sample.position_error_m
                                                                   : -sample.position_error_m;
    sample.position_error_m = std::abs(own + map_error(generator));
    sample.map_accuracy_m = 0.3;
  }
  const ScoreCalibration fit = FitCalibration(samples);
  EXPECT_NEAR(fit.position_accuracy_factor, 1.7, 0.12);
  EXPECT_NEAR(MeasureCalibration(samples, fit).position_coverage.value, 0.68, 0.01);
}

TEST(FitCalibration, HoldsOnSamplesItHasNotSeen) {
  const ScoreCalibration fit = FitCalibration(MakeSamples(20'000, 2.0, -5.0, 0.6, 5));
  const CalibrationReport report = MeasureCalibration(MakeSamples(3000, 2.0, -5.0, 0.6, 6), fit);
  EXPECT_LT(report.expected_calibration_error, 0.04);
  // 3.5 standard deviations of a share of 3000.
  EXPECT_NEAR(report.position_coverage.value, 0.68, 0.03);
  EXPECT_NEAR(report.rotation_coverage.value, 0.68, 0.03);
}

TEST(FitCalibration, StaysFiniteWhenAllAnswersAreCorrect) {
  const ScoreCalibration fit = FitCalibration(MakeSamples(100, 2.0, 100.0, 1.0, 7));
  EXPECT_NO_THROW(fit.Validate());
  EXPECT_GT(fit.Confidence(20.0, 0.1), 0.95);
  EXPECT_LT(fit.Confidence(20.0, 0.1), 1.0);
}

TEST(FitCalibration, NeverFallsWithTheScore) {
  // Better scores are worse here; the most honest rising curve is nearly flat.
  const ScoreCalibration fit = FitCalibration(MakeSamples(2000, -2.0, 5.0, 1.0, 9));
  EXPECT_DOUBLE_EQ(fit.confidence_slope, 0.1);
  const CalibrationReport report = MeasureCalibration(MakeSamples(2000, -2.0, 5.0, 1.0, 9), fit);
  double mean_confidence = 0.0, share_correct = 0.0;
  for (const ReliabilityBin& bin : report.bins) {
    mean_confidence += bin.mean_confidence * bin.num_samples / 2000.0;
    share_correct += bin.share_correct.value * bin.num_samples / 2000.0;
  }
  EXPECT_NEAR(mean_confidence, share_correct, 0.001);
}

TEST(FitCalibration, RefusesTooFewOrImpossibleSamples) {
  EXPECT_THROW(FitCalibration(MakeSamples(19, 2.0, -5.0, 1.0, 1)), Error);
  std::vector<CalibrationSample> samples = MakeSamples(20, 2.0, -5.0, 1.0, 1);
  EXPECT_NO_THROW(FitCalibration(samples));
  samples[3].predicted_position_m = 0.0;
  EXPECT_THROW(FitCalibration(samples), Error);
}

// Four answers, all in one bin: confidence 0.5 each, three are correct.
TEST(MeasureCalibration, AgreesWithValuesByHand) {
  ScoreCalibration calibration;
  calibration.confidence_slope = 1.0;
  calibration.confidence_offset = -std::log(10.0);
  calibration.position_accuracy_factor = 2.0;
  calibration.rotation_accuracy_factor = 1.0;
  std::vector<CalibrationSample> samples(4, {.score = 10.0,
                                             .correct = true,
                                             .position_error_m = 0.15,
                                             .rotation_error_rad = 0.2,
                                             .predicted_position_m = 0.1,
                                             .predicted_rotation_rad = 0.1});
  samples[0].correct = false;
  samples[0].position_error_m = 20.0;
  const CalibrationReport report = MeasureCalibration(samples, calibration);
  EXPECT_EQ(report.num_samples, 4);
  ASSERT_EQ(report.bins.size(), 1u);
  EXPECT_NEAR(report.bins[0].mean_confidence, 0.5, 1e-12);
  EXPECT_DOUBLE_EQ(report.bins[0].share_correct.value, 0.75);
  EXPECT_NEAR(report.expected_calibration_error, 0.25, 1e-12);
  EXPECT_NEAR(report.brier_score, 0.25, 1e-12);
  EXPECT_DOUBLE_EQ(report.position_coverage.value, 0.75);  // 0.15 m within 0.2 m.
  EXPECT_DOUBLE_EQ(report.rotation_coverage.value, 0.0);
}

TEST(MeasureCalibration, RefusesNoSamples) {
  EXPECT_THROW(MeasureCalibration({}, ScoreCalibration{}), Error);
}

TEST(CalibrationSamples, UndoesTheFactorsThatWereUsed) {
  EvalReport report;
  EvalAnswer answer;
  answer.result.localized = true;
  answer.result.score = 12.0;
  answer.result.position_accuracy_m = 0.6;
  answer.result.rotation_accuracy_rad = 0.02;
  answer.result.map_accuracy_m = 0.3;
  answer.position_error_m = 0.5;
  answer.rotation_error_rad = 0.01;
  report.answers = {answer, EvalAnswer{}};  // The second has no pose.
  ScoreCalibration used;
  used.position_accuracy_factor = 3.0;
  used.rotation_accuracy_factor = 2.0;
  const std::vector<CalibrationSample> samples = CalibrationSamples(report, used);
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_TRUE(samples[0].correct);
  EXPECT_NEAR(samples[0].predicted_position_m, 0.2, 1e-12);
  EXPECT_NEAR(samples[0].predicted_rotation_rad, 0.01, 1e-12);
  EXPECT_EQ(samples[0].map_accuracy_m, 0.3);
}

// Newcombe 1998, table I: 81 of 263 gives 0.2553 to 0.3662.
TEST(WilsonInterval, AgreesWithThePublishedExample) {
  const Interval interval = WilsonInterval(81, 263);
  EXPECT_NEAR(interval.value, 0.3080, 1e-4);
  EXPECT_NEAR(interval.low, 0.2553, 1e-4);
  EXPECT_NEAR(interval.high, 0.3662, 1e-4);
}

}  // namespace
}  // namespace cairn
