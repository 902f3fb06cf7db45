// Converts scores and covariances to probabilities and accuracies, calibrated on answers whose
// truth is known.
#ifndef CAIRN_ENGINE_ANSWER_SCORE_CALIBRATION_H_
#define CAIRN_ENGINE_ANSWER_SCORE_CALIBRATION_H_

namespace cairn {

// Sources of the defaults: the confidence was fitted to answers to hard queries of simulated
// cities, to photos that sparse maps lack, and to queries from elsewhere (docs/math/metrics.md,
// "Calibration"). FitCalibration (lab/calibration) fits the radii; their defaults come from 585
// answers in a simulated grid city. Experiment 19_calibration tests all of them on other cities.
struct ScoreCalibration {
  // The probability that a pose is within 3 m and 10 degrees of the truth is a logistic function of
  // slope * log(score) + offset. The slope is positive. Scores of 8 (the lowest score of an
  // answer), 20 and 60 mean probabilities of 0.50, 0.90 and 0.99.
  double confidence_slope = 2.4;
  double confidence_offset = -5.0;
  // The probability that a query that shows nothing of the map reaches a score is
  // exp(-false_alarm_slope * (score - false_alarm_start)), and 1 below the start. The slope is
  // positive. In theory the slope is 1; repeated descriptors make it smaller.
  double false_alarm_slope = 0.3;
  double false_alarm_start = -15.0;
  // Factors on the radii that the covariance predicts, chosen so that 68 % of the truths lie within
  // the radii. Positive.
  double position_accuracy_factor = 1.2;
  double rotation_accuracy_factor = 1.5;
  // The map's own error as a 68 % radius, meters, not negative; matches cannot reveal it. Added in
  // quadrature to the position accuracy. The default, 0.28 m, corresponds to a standard deviation
  // of 0.15 m per axis, which georegistration leaves in the simulated city. Set it to the accuracy
  // of your maps.
  double map_accuracy_m = 0.28;

  // Throws Error(kInvalidArgument), naming the field.
  void Validate() const;

  // Returns the confidence in [0, 1), which rises with the score; a score that is not positive
  // counts as 1e-9. The calibration assumes a position accuracy far below 3 m. Otherwise the
  // confidence is multiplied by the probability that an isotropic Gaussian with this 68 % radius
  // lies within 3 m.
  double Confidence(double score, double position_accuracy_m) const;
  // In (0, 1]; falls as the score rises.
  double FalseAlarmRate(double score) const;

  // Convert the 68 % radii that the covariance predicts to the reported radii.
  double PositionAccuracyM(double predicted_m) const;
  double RotationAccuracyRad(double predicted_rad) const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_ANSWER_SCORE_CALIBRATION_H_
