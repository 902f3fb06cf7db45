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
  // A rival does not make the answer ambiguous if the likely inliers decide between the two poses;
  // see answer.cc.
  ScoreCalibration calibration;  // Of the reported confidence and accuracies.

  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_ANSWER_ANSWER_OPTIONS_H_
