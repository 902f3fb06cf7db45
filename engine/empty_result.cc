#include "engine/empty_result.h"

#include "engine/explain_miss.h"

namespace cairn {

LocalizeResult EmptyResult(const LocalizeQuery& query, const MapSnapshot* snapshot) {
  LocalizeResult result;
  if (snapshot != nullptr) {
    result.map_version = snapshot->version();
    result.map_is_stale = snapshot->is_stale();
  }
  result.counters.num_keypoints = query.num_features();
  result.counters.used_prior = query.prior.has_value();
  result.counters.used_gravity = query.down_in_cam.has_value();
  return result;
}

LocalizeResult LateResult(const LocalizeQuery& query, const LocalizerOptions& options,
                          const MapSnapshot& snapshot) {
  LocalizeResult late = EmptyResult(query, &snapshot);
  late.reason = NotLocalizedReason::kTimeout;
  late.reason_text = ExplainMiss(query, late, options, nullptr);
  return late;
}

}  // namespace cairn
