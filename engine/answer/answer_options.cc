#include "engine/answer/answer_options.h"

#include <cmath>

#include "core/require.h"

namespace cairn {

void AnswerOptions::Validate() const {
  RequireOption(!std::isnan(min_score), "answer.min_score must be a number");
  RequireOption(ambiguous_score_ratio > 0.0 && ambiguous_score_ratio <= 1.0,
                "answer.ambiguous_score_ratio must lie in (0, 1]");
  RequireOption(ambiguous_distance_m > 0.0, "answer.ambiguous_distance_m must be positive");
  RequireOption(ambiguous_rotation_rad > 0.0, "answer.ambiguous_rotation_rad must be positive");
  calibration.Validate();
}

}  // namespace cairn
