// What a score and a covariance are worth: learned from answers whose truth is known.
#ifndef CAIRN_ENGINE_ANSWER_SCORE_CALIBRATION_H_
#define CAIRN_ENGINE_ANSWER_SCORE_CALIBRATION_H_

namespace cairn {

// The confidence was set after answers to hard queries of simulated cities, to photos that sparse
// maps lack, and to queries from elsewhere; docs/math/metrics.md, "Calibration". FitCalibration
// (lab/calibration) fits the radii, whose defaults are of 585 answers in a simulated grid city.
// Experiment 19_calibration holds all against other cities.
struct ScoreCalibration {
  // The probability that a pose is within 3 m and 10 degrees of the truth is a logistic function of
  // the logarithm of its score, slope * log(score) + offset; the slope is positive. A score of 8,
  // where answers begin, means 0.50, 20 mean 0.90 and 60 mean 0.99.
  double confidence_slope = 2.4;
  double confidence_offset = -5.0;
  // The probability that a query that shows nothing of the map reaches a score is
  // exp(-false_alarm_slope * (score - false_alarm_start)), 1 below the start; the slope is
  // positive. In theory the slope is 1; descriptors that repeat make it smaller.
  double false_alarm_slope = 0.3;
  double false_alarm_start = -15.0;
  // What the radii that the covariance predicts are multiplied with, so that 68 % of the truths lie
  // within; positive.
  double position_accuracy_factor = 1.2;
  double rotation_accuracy_factor = 1.5;
  // What matches cannot tell: how far the map itself is from where it should be, as a 68 % radius,
  // metres, not negative. Adds in quadrature to the position accuracy. 0.28 m is what a standard
  // deviation of 0.15 m per axis makes, as georegistration leaves in the simulated city; set it to
  // what your maps have.
  double map_accuracy_m = 0.28;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;

  // In [0, 1), rising with the score; a score that is not positive counts as 1e-9. This holds if
  // the reported position accuracy is far below 3 m; else it is multiplied by the probability that
  // an isotropic Gaussian with this 68 % radius lies within 3 m.
  double Confidence(double score, double position_accuracy_m) const;
  // In (0, 1], falling with the score.
  double FalseAlarmRate(double score) const;

  // The reported 68 % radii for those that the covariance predicts.
  double PositionAccuracyM(double predicted_m) const;
  double RotationAccuracyRad(double predicted_rad) const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_ANSWER_SCORE_CALIBRATION_H_
