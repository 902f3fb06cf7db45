// Converts scores to probabilities, and the covariances that matches predict to covariances of
// true errors, calibrated on answers whose truth is known.
#ifndef CAIRN_ENGINE_ANSWER_SCORE_CALIBRATION_H_
#define CAIRN_ENGINE_ANSWER_SCORE_CALIBRATION_H_

#include <Eigen/Core>

namespace cairn {

// Sources of the defaults: the confidence was fitted to answers to hard queries of simulated
// cities, to photos that sparse maps lack, and to queries from elsewhere (docs/math/metrics.md,
// "Calibration"). The factors of the radii are those of real photos, and experiment
// 19_calibration tests them on simulated cities (docs/decisions/0038).
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
  double false_alarm_start = -20.0;
  // Factors on the standard deviations that the matches predict, chosen so that 68 % of the truths
  // lie within the radii. Positive.
  double position_accuracy_factor = 1.2;
  double rotation_accuracy_factor = 1.3;
  // How far a map that does not know it is from its true place on Earth: a 68 % radius, meters, not
  // negative. Maps made since sessions keep their accuracy (SessionAccuracy) know it.
  double map_accuracy_m = 0.28;

  // Throws Error(kInvalidArgument), naming the field.
  void Validate() const;

  // Returns the confidence in [0, 1), which rises with the score; a score that is not positive
  // counts as 1e-9. The calibration assumes a position accuracy in the map far below 3 m. Otherwise
  // the confidence is multiplied by the probability that an isotropic Gaussian with this 68 %
  // radius lies within 3 m.
  double Confidence(double score, double position_accuracy_m) const;
  // In (0, 1]; falls as the score rises.
  double FalseAlarmRate(double score) const;

  // Converts the covariance of (rotation, translation) that the matches predict to the covariance
  // relative to the map: multiplies it by the factors, and by a number with which the radius of the
  // position grows as if `in_map_accuracy_m` were added in quadrature. That is how far parts of the
  // map disagree, a 68 % radius. Landmarks that are off together move a pose, and turn it, where
  // the landmarks' own errors would.
  Eigen::Matrix<double, 6, 6> Calibrated(const Eigen::Matrix<double, 6, 6>& predicted,
                                         double in_map_accuracy_m) const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_ANSWER_SCORE_CALIBRATION_H_
