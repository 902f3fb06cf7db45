// Options of the answer stage.
#ifndef CAIRN_ENGINE_ANSWER_ANSWER_OPTIONS_H_
#define CAIRN_ENGINE_ANSWER_ANSWER_OPTIONS_H_

#include "engine/answer/score_calibration.h"

namespace cairn {

// When the best hypothesis is an answer.
struct AnswerOptions {
  // A lower score (LocalizeResult::score) is no answer: fewer than half of such poses are right.
  double min_score = 8.0;
  // AMBIGUOUS if another hypothesis has at least this share of the best one's score,
  double ambiguous_score_ratio = 0.8;
  // and lies at least this far from it, metres, or is turned by at least this, radians,
  double ambiguous_distance_m = 5.0;
  double ambiguous_rotation_rad = 0.2617994;  // 15 degrees.
  // unless one of the two decides it by likely inliers: the other has at most this share of them,
  // and if both were equally good, the keypoints that only one of them explains would fall so
  // unevenly with a probability of at most exp(-decisive_evidence). The score alone cannot tell: it
  // saturates at dense matches. Where facades repeat to the last detail, the wrong one may have
  // a tenth more inliers than the right one, because the map saw it better: hence the share.
  double decisive_inlier_share = 0.85;
  double decisive_evidence = 6.9;  // One in a thousand.
  ScoreCalibration calibration;    // Of the confidence and the accuracies that are reported.

  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_ANSWER_ANSWER_OPTIONS_H_
