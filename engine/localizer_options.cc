#include "engine/localizer_options.h"

#include "core/error.h"

namespace cairn {

void AnswerOptions::Validate() const {
  if (!(min_effective_inliers >= 0.0)) {
    throw Error(ErrorCode::kInvalidArgument, "answer.min_effective_inliers must not be negative");
  }
  if (!(ambiguous_score_ratio > 0.0 && ambiguous_score_ratio <= 1.0)) {
    throw Error(ErrorCode::kInvalidArgument, "answer.ambiguous_score_ratio must be within (0, 1]");
  }
  if (!(decisive_inlier_share >= 0.0 && decisive_inlier_share <= 1.0) ||
      !(decisive_evidence > 0.0)) {
    throw Error(ErrorCode::kInvalidArgument,
                "answer: decisive_inlier_share must be within [0, 1], decisive_evidence positive");
  }
  if (!(ambiguous_distance_m > 0.0) || !(ambiguous_rotation_rad > 0.0)) {
    throw Error(ErrorCode::kInvalidArgument, "answer: ambiguity distances must be positive");
  }
  calibration.Validate();
}

void LocalizerOptions::Validate() const {
  if (num_threads < 1 || num_threads > 1024) {
    throw Error(ErrorCode::kInvalidArgument, "num_threads must lie in [1, 1024]");
  }
  prior.Validate();
  tiles.Validate();
  matching.Validate();
  voting.Validate();
  pose.Validate();
  refinement.Validate();
  answer.Validate();
}

}  // namespace cairn
