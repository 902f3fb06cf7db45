#include "cli/options/cairn_options.h"

namespace cairn {
namespace {

constexpr EnumName<AppearanceKind> kAppearanceNames[] = {{"kmeans", AppearanceKind::kKMeans},
                                                         {"kmedoids", AppearanceKind::kKMedoids},
                                                         {"random", AppearanceKind::kRandom}};

constexpr EnumName<ProjectionKind> kProjectionNames[] = {
    {"principal_components", ProjectionKind::kPrincipalComponents},
    {"likelihood_ratio", ProjectionKind::kLikelihoodRatio}};

constexpr EnumName<Unanchored> kUnanchoredNames[] = {{"accept", Unanchored::kAccept},
                                                     {"refuse", Unanchored::kRefuse},
                                                     {"refuse_always", Unanchored::kRefuseAlways}};

constexpr EnumName<SessionFitting> kFittingNames[] = {{"bend", SessionFitting::kBend},
                                                      {"adjust", SessionFitting::kAdjust}};

void DescribeCodebook(CodebookOptions* options, OptionList* list) {
  list->Add(
      "source", &options->source, kCodebookSourceNames,
      "Codebook of a new map: the one that comes with Cairn, one that is trained on the "
      "first session, or (auto) trained if the session has min_training_descriptors, else shipped");
  list->Add("min_training_descriptors", &options->min_training_descriptors,
            "For auto: fewest descriptors of landmarks in the first session that train a codebook");
  list->Add("projection", &options->projection, kProjectionNames,
            "principal_components keeps what varies most; likelihood_ratio keeps what tells "
            "landmarks apart");
  list->Add("projected_dim", &options->projected_dim,
            "Dimensions of a descriptor after the projection");
  list->Add("num_subspaces", &options->num_subspaces,
            "Bytes of a descriptor; has to divide projected_dim");
  list->Add("max_training_descriptors", &options->max_training_descriptors,
            "Most descriptors that the codebook is trained on");
  list->Add("seed", &options->seed, "Seed of the training");
}

void DescribeSelection(LandmarkSelectionOptions* options, OptionList* list) {
  list->Add("kind", &options->kind, kLandmarkSelectionNames,
            "observation_count keeps the most observed landmarks of each keyframe; coverage solves "
            "the paper's integer program, which is better below 16,000 descriptors");
  list->Add("max_descriptors", &options->max_descriptors, "Most descriptors of a tile");
  list->Add("min_observations", &options->min_observations, "Fewest observations of a landmark");
  list->Add("max_landmarks", &options->max_landmarks,
            "For coverage: most landmarks of a tile, in place of max_descriptors; 0: "
            "max_descriptors counts");
  list->Add("min_landmarks_per_keyframe", &options->min_landmarks_per_keyframe,
            "For coverage: landmarks that each keyframe should see");
  list->Add("missing_landmark_cost", &options->missing_landmark_cost,
            "For coverage: cost of each landmark that a keyframe lacks, in observations");
  list->Add("max_iterations", &options->max_iterations, "For coverage: most rounds of the solver");
}

void DescribeAppearance(AppearanceOptions* options, OptionList* list) {
  list->Add("kind", &options->kind, kAppearanceNames,
            "Descriptors of a landmark: means of clusters, their medoids, or a random subset");
  list->Add("count", &options->count,
            "Descriptors of every landmark; 0 takes ratio, min_count and max_count instead");
  list->Add("ratio", &options->ratio, "Share of a landmark's descriptors that is kept");
  list->Add("min_count", &options->min_count, "Fewest descriptors of a landmark");
  list->Add("max_count", &options->max_count, "Most descriptors of a landmark");
  list->Add("seed", &options->seed, "Seed of clusters and subsets");
}

void DescribeAgreement(AgreementOptions* options, OptionList* list) {
  list->Add("max_moved_m", &options->max_moved_m,
            "Farthest that a session with accurate positions is moved, meters");
  list->Add("max_turned_rad", &options->max_turned_rad,
            "Most that a session with accurate positions is turned, radians");
  list->Add("max_scale_change", &options->max_scale_change,
            "Largest difference of a session's size, as share");
  list->Add(
      "position_accuracy_m", &options->position_accuracy_m,
      "Radius that contains 68 % of the positions that placed the session, meters; the limits "
      "above grow with it. 0: that of --georef or --gps-accuracy");
  list->Add("min_agreeing_share", &options->min_agreeing_share,
            "Smallest share of the recognized photos that one motion of the session explains");
  list->Add("min_recognized_share", &options->min_recognized_share,
            "Smallest share of the photos that the map should recognize and does");
  list->Add("min_expected", &options->min_expected,
            "With fewer photos that the map should recognize, min_recognized_share does not count");
  list->Add("unanchored", &options->unanchored, kUnanchoredNames,
            "What becomes of a session that is not anchored in the map: it is taken as it is, or "
            "refused where the map knows the place, as cairn map does, or refused always");
}

void DescribeGate(GateOptions* options, OptionList* list) {
  list->Add("max_lost_share", &options->max_lost_share,
            "Largest share of the map's keyframes, of those that are asked for, that the new "
            "version may no longer localize; 1 (--force): all of them");
}

void DescribeLinking(LinkOptions* options, OptionList* list) {
  list->Add("placement_sigma_m", &options->placement_sigma_m,
            "Standard deviation of a session's placement, meters");
  list->Add("max_distance_sigmas", &options->max_distance_sigmas,
            "Largest distance of two landmarks, standard deviations");
  list->Add("max_error_sigmas", &options->max_error_sigmas,
            "Largest error of the known landmark in the session's photos, standard deviations");
  list->Add("keypoint_sigma_px", &options->keypoint_sigma_px,
            "Standard deviation of a keypoint at a focal length of 500 pixels, pixels");
  list->Add("max_azimuth_rad", &options->max_azimuth_rad,
            "Largest difference of viewing directions, radians");
  list->Add("max_log2_size", &options->max_log2_size, "Largest difference of sizes, octaves");
  list->Add("max_orientation_rad", &options->max_orientation_rad,
            "Largest difference of orientations, radians");
  list->Add("max_distance_quantile", &options->max_distance_quantile,
            "Largest descriptor distance, as quantile of distances within landmarks");
  list->Add("max_ratio", &options->max_ratio,
            "Largest ratio of squared descriptor distances to the second best landmark");
}

void DescribeUpkeep(UpkeepOptions* options, OptionList* list) {
  list->Add("enough_landmarks", &options->enough_landmarks,
            "A session adds landmarks until each of its photos sees this many");
  list->Add("least_existence", &options->least_existence,
            "Landmarks that exist with a smaller probability go");
  list->AddSection("linking", "When a landmark of a session is one of the map",
                   [&] { DescribeLinking(&options->linking, list); });
  list->AddSection("merging", "How sessions share a landmark", [&] {
    list->Add("old_weight_share", &options->merging.old_weight_share,
              "Weight of the sights before a session, as share");
    list->Add("same_look_share", &options->merging.same_look_share,
              "Descriptors are averaged up to this share of the median distance within landmarks");
    list->Add("least_sigma_m", &options->merging.least_sigma_m,
              "Smallest standard deviation of a position, meters");
  });
  list->AddSection("viewpoints", "When two photos have the same viewpoint", [&] {
    list->Add("radius_m", &options->viewpoints.radius_m, "Largest distance, meters");
    list->Add("angle_rad", &options->viewpoints.angle_rad,
              "Largest angle between optical axes, radians");
  });
  list->AddSection("persistence", "How landmarks fade", [&] {
    list->Add("loss_per_year", &options->persistence.loss_per_year,
              "Probability that a landmark is gone within a year");
    list->Add("least_miss_share", &options->persistence.least_miss_share,
              "Smallest probability that a session misses a landmark that is there");
  });
}

}  // namespace

void DescribeIngest(IngestOptions* options, OptionList* list) {
  list->Add("max_sigma_m", &options->max_sigma_m,
            "Landmarks with a larger standard deviation of the position are dropped, meters");
  list->Add("max_reprojection_error_px", &options->max_reprojection_error_px,
            "Landmarks with a larger median reprojection error are dropped, pixels");
  list->Add("earth_accuracy_m", &options->earth_accuracy_m,
            "How far the session is from its true place on Earth, 68 % radius, meters; 0: as the "
            "georegistration estimates it");
  list->Add("earth_accuracy_rad", &options->earth_accuracy_rad,
            "How far the session is from its true direction, 68 % radius, radians; counts if "
            "earth_accuracy_m is set");
  list->Add("fitting", &options->fitting, kFittingNames,
            "How an anchored session follows the map: bent by a smooth drift, or also adjusted "
            "with the landmarks of the map held; cairn map adjusts");
  list->AddSection("codebook",
                   "How descriptors are compressed; counts for the first session of a map only",
                   [&] { DescribeCodebook(&options->codebook, list); });
  list->AddSection("selection", "Which landmarks of a tile are kept",
                   [&] { DescribeSelection(&options->selection, list); });
  list->AddSection("appearance", "Which descriptors represent a landmark",
                   [&] { DescribeAppearance(&options->appearance, list); });
  list->AddSection("agreement", "How far a session may contradict the map",
                   [&] { DescribeAgreement(&options->agreement, list); });
  list->AddSection("gate", "What an update may take from the map",
                   [&] { DescribeGate(&options->gate, list); });
  list->AddSection("upkeep", "What becomes of a place that the map knows",
                   [&] { DescribeUpkeep(&options->upkeep, list); });
}

}  // namespace cairn
