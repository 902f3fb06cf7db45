// Options of the answer stage.
#ifndef CAIRN_ENGINE_ANSWER_ANSWER_OPTIONS_H_
#define CAIRN_ENGINE_ANSWER_ANSWER_OPTIONS_H_

#include "engine/answer/score_calibration.h"

namespace cairn {

// Decides when the best hypothesis is an answer.
struct AnswerOptions {
  // A hypothesis with a lower score (LocalizeResult::score) is not an answer: fewer than half of
  // such poses are right.
  double min_score = 8.0;
  // The answer is AMBIGUOUS if another hypothesis rivals the best one: the rival has at least this
  // share of the best score, and is at least ambiguous_distance_m away or turned by at least
  // ambiguous_rotation_rad.
  double ambiguous_score_ratio = 0.8;
  double ambiguous_distance_m = 5.0;
  double ambiguous_rotation_rad = 0.2617994;  // 15 degrees.
  // A rival does not make the answer ambiguous if likely inliers decide between the two poses. Two
  // conditions must hold. First, the loser has at most decisive_inlier_share of the winner's likely
  // inliers. Second, if both poses were equally good, the keypoints that only one of them explains
  // would be split as unevenly with a probability of at most exp(-decisive_evidence). The score
  // alone cannot decide, because it saturates at dense matches. The share is needed where facades
  // repeat in every detail: the wrong pose may then have a tenth more inliers than the right one,
  // because the map saw the wrong facade better.
  double decisive_inlier_share = 0.85;
  double decisive_evidence = 6.9;  // One in a thousand.
  ScoreCalibration calibration;    // Of the reported confidence and accuracies.

  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_ANSWER_ANSWER_OPTIONS_H_
