// Makes the engine's confidence a probability and its accuracies honest, and measures how far they
// are. The definitions are in docs/math/metrics.md, "Calibration".
#ifndef CAIRN_LAB_CALIBRATION_CALIBRATION_H_
#define CAIRN_LAB_CALIBRATION_CALIBRATION_H_

#include <vector>

#include "engine/answer/score_calibration.h"
#include "eval/evaluation.h"

namespace cairn {

// What calibration needs of one answer with a pose.
struct CalibrationSample {
  double score = 0.0;    // Positive.
  bool correct = false;  // Within 3 m and 10 degrees of the truth.
  double position_error_m = 0.0;
  double rotation_error_rad = 0.0;
  // The radii that the covariance predicts, before any calibration; positive.
  double predicted_position_m = 0.0;
  double predicted_rotation_rad = 0.0;
};

// The answers with a pose. `used` is the calibration of the localizer that gave them: what it did
// to the radii is undone.
std::vector<CalibrationSample> CalibrationSamples(const EvalReport& report,
                                                  const ScoreCalibration& used);

// The maximum-likelihood logistic of log(score), and radii that hold 68 % of the truths (wrong
// answers count as outside): of the map accuracies on a grid with the factor that each needs, the
// pair whose coverage is most even from small predicted radii to large ones. The likelihood has one
// correct and one wrong answer more, at the median score, so that samples without a wrong answer
// have a fit too; a slope that comes out below 0.1 is set to that. Throws Error(kInvalidArgument)
// with fewer than 20 samples or one that is not positive where it must be.
ScoreCalibration FitCalibration(const std::vector<CalibrationSample>& samples);

// One bar of a reliability diagram.
struct ReliabilityBin {
  double mean_confidence = 0.0;
  Interval share_correct;  // 95 % Wilson interval.
  int num_samples = 0;
};

struct CalibrationReport {
  int num_samples = 0;
  // Ten bins of equally many samples, by confidence; fewer where there are fewer than 10 samples a
  // bin.
  std::vector<ReliabilityBin> bins;
  // Mean over samples of |confidence - share correct| of the bin; sampling noise makes it positive
  // even for a perfect calibration.
  double expected_calibration_error = 0.0;
  double brier_score = 0.0;    // Mean squared difference of confidence and outcome.
  Interval position_coverage;  // Share of truths within the reported radius; 0.68 is right.
  Interval rotation_coverage;  // 95 % Wilson intervals.
};

// Measures a calibration on samples; on others than it was fitted to, or it flatters. Throws
// Error(kInvalidArgument) without samples.
CalibrationReport MeasureCalibration(const std::vector<CalibrationSample>& samples,
                                     const ScoreCalibration& calibration);

}  // namespace cairn

#endif  // CAIRN_LAB_CALIBRATION_CALIBRATION_H_
