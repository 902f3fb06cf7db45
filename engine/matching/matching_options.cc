#include "engine/matching/matching_options.h"

#include <limits>

#include "core/angles.h"
#include "core/require.h"

namespace cairn {

void MatchingOptions::Validate() const {
  index.Validate();
  RequireWithin("matching.deadline_share", deadline_share, 0.0, 1.0);
  RequireWithin("matching.max_neighbors", max_neighbors, 1, 64);
  RequireWithin("matching.max_keypoints_of_landmark", max_keypoints_of_landmark, 1, 1'000'000);
  RequireWithin("matching.distance_quantile", distance_quantile, 0.05, 0.95);
  RequireWithin("matching.max_word_ratio", max_word_ratio, 1e-3, 1e3);
  RequireWithin("matching.orientation_weight", orientation_weight, 0.0, 1e6);
  RequireWithin("matching.position_weight", position_weight, 0.0, 1e6);
  RequireWithin("matching.viewing_distance_m", viewing_distance_m, 0.0, 1e6);
  RequireWithin("matching.max_orientation_difference_rad", max_orientation_difference_rad, 1e-3,
                kPi);
  RequireWithin("matching.max_position_excess_sigmas", max_position_excess_sigmas, 0.0,
                std::numeric_limits<double>::infinity());
  RequireOption(
      distance_filter != DistanceFilter::kWordRatio || index.num_reference_words > 0,
      "matching.index.num_reference_words is 0; the word ratio filter needs reference words");
}

}  // namespace cairn
