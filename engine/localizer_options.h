// Every knob of a query, nested by stage.
#ifndef CAIRN_ENGINE_LOCALIZER_OPTIONS_H_
#define CAIRN_ENGINE_LOCALIZER_OPTIONS_H_

#include <cstdint>

#include "engine/matching/matching_options.h"
#include "engine/pose/pose_options.h"
#include "engine/prior/prior_options.h"
#include "engine/refinement/refinement_options.h"
#include "engine/score_calibration.h"
#include "engine/tiles/tiles_options.h"
#include "engine/voting/voting_options.h"

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

struct LocalizerOptions {
  PriorOptions prior;
  TilesOptions tiles;
  MatchingOptions matching;
  VotingOptions voting;
  PoseOptions pose;
  RefinementOptions refinement;
  AnswerOptions answer;

  // Threads that a query may use while no other query needs them, its own among them; the others
  // are shared by all queries of a localizer. At least 1. The answer does not depend on it.
  int num_threads = 1;

  // Seed of everything random in a query; the same seed gives the same answer.
  uint64_t seed = 1;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_LOCALIZER_OPTIONS_H_
