// The descriptions (core/option_visit.h) of the options of ingest/tiles. The structs stand where
// they are used; few read their descriptions.
#ifndef CAIRN_INGEST_TILES_TILE_OPTION_VISIT_H_
#define CAIRN_INGEST_TILES_TILE_OPTION_VISIT_H_

#include "core/option_visit.h"
#include "ingest/tiles/appearance.h"
#include "ingest/tiles/landmark_history.h"
#include "ingest/tiles/landmark_selection.h"
#include "ingest/tiles/link_landmarks.h"
#include "ingest/tiles/merge_tiles.h"
#include "ingest/tiles/viewpoints.h"

namespace cairn {

template <OptionsOf<LandmarkSelectionOptions> Options, typename Visitor>
void VisitOptions(Options& options, const Visitor& visitor) {
  auto& [kind, max_descriptors, min_observations, max_landmarks, min_landmarks_per_keyframe,
         missing_landmark_cost, max_iterations] = options;
  visitor.Visit("kind", kind, AnyValue(),
                "observation_count keeps the most observed landmarks of each keyframe; coverage "
                "solves the paper's integer program, which is better below 16,000 descriptors");
  visitor.Visit("max_descriptors", max_descriptors, AtLeast(1), "Most descriptors of a tile");
  visitor.Visit("max_landmarks", max_landmarks, AtLeast(0),
                "For coverage: most landmarks of a tile, in place of max_descriptors; 0: "
                "max_descriptors counts");
  visitor.Visit("min_observations", min_observations, AtLeast(2),
                "Fewest observations of a landmark");
  visitor.Visit("min_landmarks_per_keyframe", min_landmarks_per_keyframe, AtLeast(0),
                "For coverage: landmarks that each keyframe should see");
  visitor.Visit("missing_landmark_cost", missing_landmark_cost, FiniteFrom(0.0),
                "For coverage: cost of each landmark that a keyframe lacks, in observations");
  visitor.Visit("max_iterations", max_iterations, AtLeast(1),
                "For coverage: most rounds of the solver");
}

template <OptionsOf<AppearanceOptions> Options, typename Visitor>
void VisitOptions(Options& options, const Visitor& visitor) {
  auto& [kind, count, ratio, min_count, max_count, seed] = options;
  visitor.Visit("kind", kind, AnyValue(),
                "Descriptors of a landmark: means of clusters, their medoids, or a random subset");
  visitor.Visit("count", count, AtLeast(0),
                "Descriptors of every landmark; 0 takes ratio, min_count and max_count instead");
  visitor.Visit("ratio", ratio, WithinOf(0.0, 1.0),
                "Share of a landmark's descriptors that is kept");
  visitor.Visit("min_count", min_count, AtLeast(1), "Fewest descriptors of a landmark");
  visitor.Visit("max_count", max_count, AtLeast(1), "Most descriptors of a landmark");
  visitor.Visit("seed", seed, AnyValue(), "Seed of clusters and subsets");
}

template <OptionsOf<LinkOptions> Options, typename Visitor>
void VisitOptions(Options& options, const Visitor& visitor) {
  auto& [placement_sigma_m, max_distance_sigmas, max_error_sigmas, keypoint_sigma_px,
         max_azimuth_rad, max_log2_size, max_orientation_rad, max_distance_quantile, max_ratio] =
      options;
  visitor.Visit("placement_sigma_m", placement_sigma_m, AtLeast(0.0),
                "Standard deviation of a session's placement, meters");
  visitor.Visit("max_distance_sigmas", max_distance_sigmas, Above(0.0),
                "Largest distance of two landmarks, standard deviations");
  visitor.Visit("max_error_sigmas", max_error_sigmas, Above(0.0),
                "Largest error of the known landmark in the session's photos, standard deviations");
  visitor.Visit("keypoint_sigma_px", keypoint_sigma_px, Above(0.0),
                "Standard deviation of a keypoint at a focal length of 500 pixels, pixels");
  visitor.Visit("max_azimuth_rad", max_azimuth_rad, Above(0.0),
                "Largest difference of viewing directions, radians");
  visitor.Visit("max_log2_size", max_log2_size, Above(0.0), "Largest difference of sizes, octaves");
  visitor.Visit("max_orientation_rad", max_orientation_rad, Above(0.0),
                "Largest difference of orientations, radians");
  visitor.Visit("max_distance_quantile", max_distance_quantile, WithinOf(0.05, 0.95),
                "Largest descriptor distance, as quantile of distances within landmarks");
  visitor.Visit("max_ratio", max_ratio, OptionRange{.min = 0.0, .max = 1.0, .has_min = false},
                "Largest ratio of squared descriptor distances to the second best landmark");
}

template <OptionsOf<MergeOptions> Options, typename Visitor>
void VisitOptions(Options& options, const Visitor& visitor) {
  auto& [old_weight_share, same_look_share, least_sigma_m] = options;
  visitor.Visit("old_weight_share", old_weight_share, WithinOf(0.0, 1.0),
                "Weight of the observations before a session, as share");
  visitor.Visit(
      "same_look_share", same_look_share, AtLeast(0.0),
      "Descriptors are averaged up to this share of the median distance within landmarks");
  visitor.Visit("least_sigma_m", least_sigma_m, Above(0.0),
                "Smallest standard deviation of a position, meters");
}

template <OptionsOf<ViewpointOptions> Options, typename Visitor>
void VisitOptions(Options& options, const Visitor& visitor) {
  auto& [radius_m, angle_rad] = options;
  visitor.Visit("radius_m", radius_m, Above(0.0), "Largest distance, meters");
  visitor.Visit("angle_rad", angle_rad, Above(0.0), "Largest angle between optical axes, radians");
}

template <OptionsOf<PersistenceOptions> Options, typename Visitor>
void VisitOptions(Options& options, const Visitor& visitor) {
  auto& [loss_per_year, least_miss_share] = options;
  visitor.Visit("loss_per_year", loss_per_year,
                OptionRange{.min = 0.0, .max = 1.0, .has_max = false},
                "Probability that a landmark is gone within a year");
  visitor.Visit("least_miss_share", least_miss_share,
                OptionRange{.min = 0.0, .max = 1.0, .has_min = false},
                "Smallest probability that a session misses a landmark that is there");
}

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_TILE_OPTION_VISIT_H_
