// The names of the options that a plan stores; private to ingest/maps.
#ifndef CAIRN_INGEST_MAPS_PLAN_OPTIONS_H_
#define CAIRN_INGEST_MAPS_PLAN_OPTIONS_H_

#include "ingest/ingest_options.h"

namespace cairn {

// The structured bindings name every member, so this does not compile if there is a new one.

template <typename Options, typename Visit>
void VisitSelection(Options& options, const Visit& visit) {
  auto& [kind, max_descriptors, min_observations, max_landmarks, min_landmarks_per_keyframe,
         missing_landmark_cost, max_iterations] = options;
  visit("selection.kind", kind);
  visit("selection.max_descriptors", max_descriptors);
  visit("selection.min_observations", min_observations);
  visit("selection.max_landmarks", max_landmarks);
  visit("selection.min_landmarks_per_keyframe", min_landmarks_per_keyframe);
  visit("selection.missing_landmark_cost", missing_landmark_cost);
  visit("selection.max_iterations", max_iterations);
}

template <typename Options, typename Visit>
void VisitAppearance(Options& options, const Visit& visit) {
  auto& [kind, count, ratio, min_count, max_count, seed] = options;
  visit("appearance.kind", kind);
  visit("appearance.count", count);
  visit("appearance.ratio", ratio);
  visit("appearance.min_count", min_count);
  visit("appearance.max_count", max_count);
  visit("appearance.seed", seed);
}

template <typename Options, typename Visit>
void VisitLinking(Options& options, const Visit& visit) {
  auto& [placement_sigma_m, max_distance_sigmas, max_error_sigmas, keypoint_sigma_px,
         max_azimuth_rad, max_log2_size, max_orientation_rad, max_distance_quantile, max_ratio] =
      options;
  visit("linking.placement_sigma_m", placement_sigma_m);
  visit("linking.max_distance_sigmas", max_distance_sigmas);
  visit("linking.max_error_sigmas", max_error_sigmas);
  visit("linking.keypoint_sigma_px", keypoint_sigma_px);
  visit("linking.max_azimuth_rad", max_azimuth_rad);
  visit("linking.max_log2_size", max_log2_size);
  visit("linking.max_orientation_rad", max_orientation_rad);
  visit("linking.max_distance_quantile", max_distance_quantile);
  visit("linking.max_ratio", max_ratio);
}

template <typename Options, typename Visit>
void VisitUpkeep(Options& options, const Visit& visit) {
  auto& [linking, merging, viewpoints, persistence, enough_landmarks, least_existence] = options;
  VisitLinking(linking, visit);
  auto& [old_weight_share, same_look_share, least_sigma_m] = merging;
  visit("merging.old_weight_share", old_weight_share);
  visit("merging.same_look_share", same_look_share);
  visit("merging.least_sigma_m", least_sigma_m);
  auto& [radius_m, angle_rad] = viewpoints;
  visit("viewpoints.radius_m", radius_m);
  visit("viewpoints.angle_rad", angle_rad);
  auto& [loss_per_year, least_miss_share] = persistence;
  visit("persistence.loss_per_year", loss_per_year);
  visit("persistence.least_miss_share", least_miss_share);
  visit("upkeep.enough_landmarks", enough_landmarks);
  visit("upkeep.least_existence", least_existence);
}

// Calls visit(name, member) for each option. `Options` is TileOptions, const or not.
template <typename Options, typename Visit>
void VisitTileOptions(Options& options, const Visit& visit) {
  auto& [joining, selection, appearance, upkeep] = options;
  visit("joining", joining);
  VisitSelection(selection, visit);
  VisitAppearance(appearance, visit);
  VisitUpkeep(upkeep, visit);
}

}  // namespace cairn

#endif  // CAIRN_INGEST_MAPS_PLAN_OPTIONS_H_
