// Fits the engine's confidence to be a probability and its accuracies to be right, and measures how
// well they are. docs/math/metrics.md, "Calibration", defines the terms.
#ifndef CAIRN_LAB_EXPERIMENTS_MEASURE_CALIBRATION_H_
#define CAIRN_LAB_EXPERIMENTS_MEASURE_CALIBRATION_H_

#include <vector>

#include "engine/answer/score_calibration.h"
#include "eval/evaluation.h"

namespace cairn {

// The data of one answer with a pose that calibration needs.
struct CalibrationSample {
  double score = 0.0;    // Positive.
  bool correct = false;  // Within 3 m and 10 degrees of the truth.
  double position_error_m = 0.0;
  double rotation_error_rad = 0.0;
  // The radii that the matches predict before any calibration; positive.
  double predicted_position_m = 0.0;
  double predicted_rotation_rad = 0.0;
  // What the accuracy of the map adds to the radii, in quadrature.
  double map_accuracy_m = 0.0;
  double map_accuracy_rad = 0.0;
};

// Returns a sample for each answer with a pose, with the radii on Earth. `used` is the calibration
// of the localizer that gave the answers; its effect on the radii is undone.
std::vector<CalibrationSample> CalibrationSamples(const EvalReport& report,
                                                  const ScoreCalibration& used);

// Fits a logistic function of log(score) by maximum likelihood, and radii that hold 68 % of the
// truths (wrong answers count as outside).
//
// Confidence: the likelihood includes one additional correct and one additional wrong answer at the
// median score, so that samples without a wrong answer have a fit, too. A slope below 0.1 is set to
// 0.1.
//
// Throws Error(kInvalidArgument) if there are fewer than 20 samples or if a value that must be
// positive is not.
ScoreCalibration FitCalibration(const std::vector<CalibrationSample>& samples);

// One bar of a reliability diagram.
struct ReliabilityBin {
  double mean_confidence = 0.0;
  Interval share_correct;  // 95 % Wilson interval.
  int num_samples = 0;
};

struct CalibrationReport {
  int num_samples = 0;
  // Ten bins with equally many samples each, ordered by confidence. There are fewer bins if a bin
  // would have fewer than 10 samples.
  std::vector<ReliabilityBin> bins;
  // Mean over the samples of |confidence - share correct| of the bin. Sampling noise makes this
  // value positive even for a perfect calibration.
  double expected_calibration_error = 0.0;
  double brier_score = 0.0;    // Mean squared difference of confidence and outcome.
  Interval position_coverage;  // Share of truths within the reported radius; target 0.68.
  Interval rotation_coverage;  // 95 % Wilson intervals.
};

// Measures a calibration on samples. Use other samples than those of the fit; otherwise the result
// is too good. Throws Error(kInvalidArgument) if there are no samples.
CalibrationReport MeasureCalibration(const std::vector<CalibrationSample>& samples,
                                     const ScoreCalibration& calibration);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_MEASURE_CALIBRATION_H_
