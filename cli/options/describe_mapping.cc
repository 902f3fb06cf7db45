#include "cli/options/cairn_options.h"

namespace cairn {
namespace {

void DescribePairs(PairOptions* options, OptionList* list) {
  list->Add("max_partners", &options->max_partners, "Photos that each photo chooses to match");
  list->Add("max_exhaustive", &options->max_exhaustive,
            "A set of at most this many photos is matched completely");
  list->Add("max_voters", &options->max_voters, "Keypoints of a photo that vote for partners");
  list->Add("max_panel", &options->max_panel,
            "Photos of one place that a photo is compared with at once");
  list->Add("neighbors_per_voter", &options->neighbors_per_voter,
            "Nearest descriptors whose photos get a vote");
  list->Add("max_distance_m", &options->max_distance_m,
            "Photos with a position choose photos within this distance, plus the accuracies, "
            "meters, and the eight nearest within 500 m");
  list->Add("default_accuracy_m", &options->default_accuracy_m,
            "Accuracy of a position that states none, meters");
}

void DescribeTwoViews(TwoViewOptions* options, OptionList* list) {
  list->Add("max_ratio", &options->descriptors.max_ratio,
            "Largest ratio of the smallest to the second smallest distance of descriptors");
  list->Add("max_distance", &options->descriptors.max_distance,
            "Largest distance of matching descriptors, which have length 1");
  list->Add("min_inliers", &options->min_inliers, "Matches that must agree with one relative pose");
  list->Add("max_iterations", &options->max_iterations, "Relative poses that are tried");
  list->Add("seed", &options->seed, "Seed of the samples");
}

void DescribeGrowth(GrowthOptions* options, OptionList* list) {
  list->Add("min_inliers", &options->min_inliers,
            "Keypoints that must see landmarks, before and after the adjustment");
  list->Add("min_link_share", &options->min_link_share,
            "A photo waits while its inliers are less than this share of those with its strongest "
            "partner outside");
  list->Add("min_witnesses", &options->min_witnesses,
            "Photos of the segment whose relative poses must agree with a photo that joins");
  list->Add("max_rotation_error_rad", &options->max_rotation_error_rad,
            "How far a rotation may differ from a relative pose, radians");
  list->Add("max_direction_error_rad", &options->max_direction_error_rad,
            "How far a direction may differ from a relative pose, radians");
  list->Add("default_gps_accuracy_m", &options->default_gps_accuracy_m,
            "Accuracy of a position that states none, meters");
  list->Add(
      "adjust_after_growth", &options->adjust_after_growth,
      "A segment is adjusted each time when it has grown by this share, of at most 200 photos");
  list->Add("min_photos", &options->min_photos, "Photos that a segment needs");
  list->Add("seed", &options->seed, "Seed of the samples");
}

void DescribeAdjust(AdjustOptions* options, OptionList* list) {
  list->Add("loss_scale_sigmas", &options->loss_scale_sigmas,
            "Scale of Cauchy's loss on reprojection errors, in standard deviations of a keypoint");
  list->Add("position_loss_scale_sigmas", &options->position_loss_scale_sigmas,
            "Scale of Cauchy's loss on positions, in their standard deviations");
  list->Add("distortion_sigma", &options->distortion_sigma,
            "Standard deviation of k1 and k2 before any photo");
  list->Add("max_iterations", &options->max_iterations, "Most iterations of a solution");
  list->Add("min_relative_change", &options->min_relative_change,
            "A solution ends when its cost falls by less than this share");
  list->Add("max_error_sigmas", &options->max_error_sigmas,
            "Observations with a larger error leave, in standard deviations of a keypoint");
  list->Add("max_rounds", &options->max_rounds, "Most solutions, with outliers leaving between");
  list->Add(
      "max_observations_of_all", &options->max_observations_of_all,
      "Of more observations, the landmarks that most photos see decide, and the others follow");
  list->Add("min_ray_angle_rad", &options->min_ray_angle_rad,
            "Landmarks whose rays span less leave, radians");
}

}  // namespace

void DescribeMapping(MappingOptions* options, OptionList* list) {
  list->AddSection("sift", "Features of the photos", [&] { DescribeSift(&options->sift, list); });
  list->AddSection("pairs", "Which photos are matched",
                   [&] { DescribePairs(&options->pairs, list); });
  list->AddSection("two_views", "The relative pose of two photos",
                   [&] { DescribeTwoViews(&options->two_views, list); });
  list->AddSection("growth", "Which photos join a segment",
                   [&] { DescribeGrowth(&options->growth, list); });
  list->AddSection("adjust", "The last adjustment, with the positions",
                   [&] { DescribeAdjust(&options->adjust, list); });
}

}  // namespace cairn
