// What a score and a covariance are worth: learned from answers whose truth is known.
#ifndef CAIRN_ENGINE_SCORE_CALIBRATION_H_
#define CAIRN_ENGINE_SCORE_CALIBRATION_H_

namespace cairn {

// Fitted by FitCalibration (eval/calibration) on one set of queries and tested on others. The
// defaults are of answers in a simulated grid city, accepted down to 3 effective inliers: the
// confidence of 381, the radii of 565. Experiment 19_calibration holds them against other cities.
struct ScoreCalibration {
  // The probability that a pose is within 3 m and 10 degrees of the truth is a logistic function of
  // the logarithm of its score, slope * log(score) + offset; the slope is positive. 5 effective
  // inliers mean 0.45, the acceptance threshold of 8 means 0.82 and 30 mean 0.998.
  double confidence_slope = 3.714;
  double confidence_offset = -6.181;
  // What the radii that the covariance predicts are multiplied with, so that 68 % of the truths lie
  // within; positive.
  double position_accuracy_factor = 2.27;
  double rotation_accuracy_factor = 1.88;
  // What matches cannot tell: how far the map itself is from where it should be, as a 68 % radius,
  // metres, not negative. Adds in quadrature to the position accuracy. 0.28 m is what a standard
  // deviation of 0.15 m per axis makes, as georegistration leaves in the simulated city; set it to
  // what your maps have.
  double map_accuracy_m = 0.28;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;

  // In (0, 1), rising with the score; a score that is not positive counts as 1e-9.
  double Confidence(double score) const;

  // The reported 68 % radii for those that the covariance predicts.
  double PositionAccuracyM(double predicted_m) const;
  double RotationAccuracyRad(double predicted_rad) const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_SCORE_CALIBRATION_H_
