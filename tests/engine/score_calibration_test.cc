#include "engine/answer/score_calibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/radius68.h"

namespace cairn {
namespace {

TEST(ScoreCalibration, ConfidenceIsALogisticOfTheLogarithm) {
  ScoreCalibration calibration;
  calibration.confidence_slope = 2.0;
  calibration.confidence_offset = -std::log(100.0);  // Even odds at a score of 10.
  EXPECT_NEAR(calibration.Confidence(10.0, 0.1), 0.5, 1e-12);
  EXPECT_NEAR(calibration.Confidence(30.0, 0.1), 0.9, 1e-12);  // Odds of 9.
}

TEST(ScoreCalibration, ConfidenceRisesWithTheScoreAndStaysAProbability) {
  const ScoreCalibration calibration;
  double last = 0.0;
  for (const double score : {-1.0, 0.0, 1.0, 8.0, 20.0, 100.0, 1000.0}) {
    const double confidence = calibration.Confidence(score, 0.1);
    EXPECT_GE(confidence, last);
    EXPECT_LE(confidence, 1.0);
    last = confidence;
  }
}

TEST(ScoreCalibration, ConfidenceFallsWhereThePositionMayBeFartherOffThanCorrect) {
  const ScoreCalibration calibration;
  const double sure = calibration.Confidence(1000.0, 0.1);
  EXPECT_NEAR(calibration.Confidence(1000.0, 3.0), 0.68 * sure, 1e-3);
  EXPECT_LT(calibration.Confidence(1000.0, 30.0), 0.01);
}

TEST(ScoreCalibration, FalseAlarmsFallWithTheScoreAndStayAProbability) {
  const ScoreCalibration calibration;
  EXPECT_EQ(calibration.FalseAlarmRate(calibration.false_alarm_start - 1.0), 1.0);
  double last = 1.0;
  for (const double score : {0.0, 1.0, 8.0, 20.0, 100.0}) {
    const double rate = calibration.FalseAlarmRate(score);
    EXPECT_LT(rate, last);
    EXPECT_GT(rate, 0.0);
    last = rate;
  }
}

TEST(ScoreCalibration, ScalesTheCovarianceAndAddsTheMap) {
  const Eigen::Matrix<double, 6, 6> root = Eigen::Matrix<double, 6, 6>::Random();
  const Eigen::Matrix<double, 6, 6> predicted = root * root.transpose();
  ScoreCalibration calibration;
  calibration.rotation_accuracy_factor = 2.0;
  calibration.position_accuracy_factor = 3.0;
  const auto calibrated = calibration.Calibrated(predicted, 0.0);
  EXPECT_NEAR(calibrated(0, 1), 4.0 * predicted(0, 1), 1e-12);
  EXPECT_NEAR(calibrated(1, 4), 6.0 * predicted(1, 4), 1e-12);
  EXPECT_NEAR(calibrated(3, 4), 9.0 * predicted(3, 4), 1e-12);
  const double radius_m = Radius68(calibrated.bottomRightCorner<3, 3>());
  const auto in_a_map = calibration.Calibrated(predicted, 0.5);
  EXPECT_NEAR(Radius68(in_a_map.bottomRightCorner<3, 3>()), std::hypot(radius_m, 0.5), 1e-12);
  // Rotations grow alike, and nothing turns.
  EXPECT_NEAR(in_a_map(0, 4) / calibrated(0, 4), in_a_map(5, 5) / calibrated(5, 5), 1e-9);
}

TEST(ScoreCalibration, RefusesNonsense) {
  for (double ScoreCalibration::*field :
       {&ScoreCalibration::confidence_slope, &ScoreCalibration::false_alarm_slope,
        &ScoreCalibration::position_accuracy_factor, &ScoreCalibration::rotation_accuracy_factor}) {
    for (const double value : {0.0, -1.0, std::numeric_limits<double>::infinity(),
                               std::numeric_limits<double>::quiet_NaN()}) {
      ScoreCalibration calibration;
      calibration.*field = value;
      EXPECT_THROW(calibration.Validate(), Error);
    }
  }
  ScoreCalibration calibration;
  calibration.confidence_offset = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(calibration.Validate(), Error);
  calibration = {};
  calibration.map_accuracy_m = -0.1;
  EXPECT_THROW(calibration.Validate(), Error);
}

}  // namespace
}  // namespace cairn
