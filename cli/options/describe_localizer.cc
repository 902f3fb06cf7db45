// The sections of a query. Reasons and measurements behind the defaults are in the headers of the
// structs.
#include "cli/options/cairn_options.h"

namespace cairn {
namespace {

constexpr EnumName<DistanceFilter> kDistanceFilterNames[] = {
    {"absolute", DistanceFilter::kAbsolute},
    {"word_ratio", DistanceFilter::kWordRatio},
    {"none", DistanceFilter::kNone}};

// OutlierFilter::kOther takes a function, which no file can hold.
constexpr EnumName<OutlierFilter> kOutlierFilterNames[] = {{"voting_4d", OutlierFilter::kVoting4d},
                                                           {"voting_3d", OutlierFilter::kVoting3d}};

constexpr EnumName<MinimalSolver> kMinimalSolverNames[] = {
    {"auto", MinimalSolver::kAuto},
    {"gravity_two_point", MinimalSolver::kGravityTwoPoint},
    {"p3p", MinimalSolver::kP3p}};

constexpr EnumName<RefinementMode> kRefinementModeNames[] = {
    {"never", RefinementMode::kNever},
    {"when_weak", RefinementMode::kWhenWeak},
    {"always", RefinementMode::kAlways}};

void DescribePrior(PriorOptions* options, OptionList* list) {
  list->Add("search_sigmas", &options->search_sigmas,
            "Search radius, in standard deviations of the prior");
  list->Add("min_radius_m", &options->min_radius_m, "Smallest search radius, meters");
  list->Add("max_radius_m", &options->max_radius_m, "Largest search radius, meters");
}

void DescribePlaces(PlacesOptions* options, OptionList* list) {
  list->Add("max_descriptors_per_tile", &options->max_descriptors_per_tile,
            "Most descriptors of a tile in the index of places");
  list->Add("max_bytes", &options->max_bytes,
            "Memory for the index of places, bytes; in larger maps a tile has fewer descriptors");
  list->Add("max_neighbors", &options->max_neighbors,
            "Descriptors of the index that a keypoint votes for");
  list->Add("max_places", &options->max_places, "Most places of a query");
  list->Add("radius_m", &options->radius_m,
            "The camera is sought so far around the middle of a place, meters");
  list->Add("convincing_confidence", &options->convincing_confidence,
            "An answer of this confidence ends the search");
}

void DescribeTiles(TilesOptions* options, OptionList* list) {
  list->Add("max_tiles", &options->max_tiles, "Most tiles of a query, nearest to the prior first");
  list->Add(
      "height_margin_m", &options->height_margin_m,
      "Height by which a camera may be below the lowest or above the highest keyframe, meters");
  list->Add("deadline_share", &options->deadline_share,
            "Share of the time until the deadline for tiles that are not in the cache");
}

void DescribeGrids(RandomGridsOptions* options, OptionList* list) {
  list->Add("num_grids", &options->num_grids, "Grids; time and memory are linear in it");
  list->Add("num_hashed_dims", &options->num_hashed_dims,
            "Dimensions of a descriptor that make up the key of a cell");
  list->Add("cell_width_sigmas", &options->cell_width_sigmas,
            "Side of a cell, in standard deviations per dimension between two descriptors of one "
            "landmark");
  list->Add("num_probes", &options->num_probes, "Cells looked into per grid");
  list->Add("max_candidates_per_cell", &options->max_candidates_per_cell,
            "Most descriptors of a cell that are compared; of a fuller cell a random subset");
  list->Add("seed", &options->seed, "Seed of rotations, shifts and subsets");
}

void DescribeLists(InvertedListsOptions* options, OptionList* list) {
  list->Add("num_lists", &options->num_lists, "Lists of a tile");
  list->Add("num_probes", &options->num_probes, "Lists looked into, nearest first");
  list->Add("num_iterations", &options->num_iterations, "Iterations of k-means");
  list->Add("seed", &options->seed, "Seed of the training sample of k-means");
}

void DescribeIndex(IndexOptions* options, OptionList* list) {
  list->Add("kind", &options->kind, kIndexKindNames, "What a tile is searched with");
  list->Add("num_reference_words", &options->num_reference_words,
            "Words per half of the vocabulary of the filter word_ratio, which needs some");
  list->AddSection("grids", "The kind random_grids", [&] { DescribeGrids(&options->grids, list); });
  list->AddSection("lists", "The kind inverted_lists; lists stored in a map are taken as they are",
                   [&] { DescribeLists(&options->lists, list); });
}

void DescribeMatching(MatchingOptions* options, OptionList* list) {
  list->Add("max_neighbors", &options->max_neighbors, "Most landmarks that match a keypoint");
  list->Add("max_keypoints_of_landmark", &options->max_keypoints_of_landmark,
            "Most keypoints that match a landmark, the nearest ones");
  list->Add("distance_filter", &options->distance_filter, kDistanceFilterNames,
            "Which descriptors may match: those within one distance for all, within a ratio to the "
            "nearest word of a vocabulary, or all");
  list->Add("distance_quantile", &options->distance_quantile,
            "For absolute: quantile of the distances between descriptors of one landmark");
  list->Add("max_word_ratio", &options->max_word_ratio,
            "For word_ratio: largest ratio to the distance of the nearest word");
  list->Add("orientation_weight", &options->orientation_weight,
            "Weight of the difference of orientations in the ranking of landmarks; 0 drops it");
  list->Add("position_weight", &options->position_weight,
            "Weight of the distance from the prior in the ranking of landmarks; 0 drops it");
  list->Add("viewing_distance_m", &options->viewing_distance_m,
            "Landmarks within this distance of the prior are equally likely, meters");
  list->Add("max_orientation_difference_rad", &options->max_orientation_difference_rad,
            "Landmarks with a larger difference of orientations do not match, radians; pi lets all "
            "pass");
  list->Add(
      "max_position_excess_sigmas", &options->max_position_excess_sigmas,
      "Landmarks that exceed viewing_distance_m by more standard deviations of the prior do not "
      "match");
  list->Add("deadline_share", &options->deadline_share,
            "Share of the time until the deadline after which the search stops");
  list->AddSection("index", "How tiles are searched",
                   [&] { DescribeIndex(&options->index, list); });
}

void DescribeVoting(VotingOptions* options, OptionList* list) {
  list->Add("filter", &options->filter, kOutlierFilterNames,
            "Dimensions of the votes: x, y, z and heading, or without z");
  list->Add("cell_xy_m", &options->cell_xy_m, "Horizontal side of a cell, meters");
  list->Add("cell_z_m", &options->cell_z_m, "Vertical side of a cell, meters");
  list->Add("yaw_step_rad", &options->yaw_step_rad, "Step of the headings, radians");
  list->Add("max_candidates", &options->max_candidates, "Most maxima that get a pose estimate");
  list->Add("min_score", &options->min_score, "Weighted distinct keypoints that a maximum needs");
  list->Add("max_distance_m", &options->max_distance_m,
            "Landmarks farther from the camera do not vote, meters");
  list->Add(
      "max_distance_factor", &options->max_distance_factor,
      "Largest factor between a distance and the one that the scale of the keypoint predicts; "
      "0 lets all pass");
  list->Add("max_azimuth_difference_rad", &options->max_azimuth_difference_rad,
            "Largest angle between the azimuths from which map and camera see a landmark, radians; "
            "pi lets all pass");
  list->Add("direction_tolerance_rad", &options->direction_tolerance_rad,
            "Largest angle between a ray and its landmark as seen from a candidate, radians");
}

void DescribePose(PoseOptions* options, OptionList* list) {
  list->Add("solver", &options->solver, kMinimalSolverNames,
            "Minimal solver; auto takes two points and gravity, and p3p without gravity");
  list->Add("max_error_px", &options->max_error_px,
            "Reprojection error of an inlier, pixels at a focal length of 500");
  list->Add("keypoint_sigma_px", &options->keypoint_sigma_px,
            "Standard deviation of a keypoint per axis, pixels");
  list->Add("min_iterations", &options->min_iterations, "Fewest samples of RANSAC");
  list->Add("max_iterations", &options->max_iterations, "Most samples of RANSAC");
  list->Add(
      "distance_weight", &options->distance_weight,
      "How much less often RANSAC samples matches with distant descriptors; 0 samples all alike");
  list->Add("min_inliers", &options->min_inliers, "Distinct keypoints that a pose needs");
  list->Add("gravity_sigma_rad", &options->gravity_sigma_rad,
            "Standard deviation of the direction of gravity per axis, radians");
}

void DescribeRefinement(RefinementOptions* options, OptionList* list) {
  list->Add("mode", &options->mode, kRefinementModeNames,
            "When keyframes are matched again; when_weak: if no pose has good_evidence");
  list->Add("good_evidence", &options->good_evidence, "Evidence of a pose that is not weak");
  list->Add("max_keyframes", &options->max_keyframes, "Most keyframes that are matched again");
  list->Add("max_pose_keyframes", &options->max_pose_keyframes,
            "Most of the best poses whose keyframes are matched again, too");
  list->Add("neighbors_per_keyframe", &options->neighbors_per_keyframe,
            "Keyframes matched along with each, those that share most landmarks");
  list->Add("min_separation_m", &options->min_separation_m,
            "Keyframes nearer to a better one that looks the same way are left out, meters");
  list->Add("min_trusted_evidence", &options->min_trusted_evidence,
            "Gravity is doubted if the best pose has less evidence");
  list->Add("max_gravity_error_sigmas", &options->max_gravity_error_sigmas,
            "Gravity is doubted if a weak pose is tilted against it by more, in "
            "pose.gravity_sigma_rad");
}

void DescribeCalibration(ScoreCalibration* options, OptionList* list) {
  list->Add("confidence_slope", &options->confidence_slope,
            "Slope of the logit of the confidence over the logarithm of the score");
  list->Add("confidence_offset", &options->confidence_offset,
            "Logit of the confidence at a score of 1");
  list->Add("false_alarm_slope", &options->false_alarm_slope,
            "The rate of false alarms falls as exp(-slope * (score - start))");
  list->Add("false_alarm_start", &options->false_alarm_start,
            "Score at which the rate of false alarms is 1");
  list->Add("position_accuracy_factor", &options->position_accuracy_factor,
            "Factor of the position accuracy that the matches predict");
  list->Add("rotation_accuracy_factor", &options->rotation_accuracy_factor,
            "Factor of the rotation accuracy that the matches predict");
  list->Add(
      "map_accuracy_m", &options->map_accuracy_m,
      "How far a map is from its true place on Earth if it does not know, 68 % radius, meters");
}

void DescribeAnswer(AnswerOptions* options, OptionList* list) {
  list->Add("min_score", &options->min_score, "A pose with a lower score is no answer");
  list->Add("ambiguous_score_ratio", &options->ambiguous_score_ratio,
            "A distant rival with this share of the best score makes an answer ambiguous");
  list->Add("ambiguous_distance_m", &options->ambiguous_distance_m,
            "Distance of a distant rival, meters");
  list->Add("ambiguous_rotation_rad", &options->ambiguous_rotation_rad,
            "Rotation of a distant rival, radians; one of the two is enough");
  list->AddSection("calibration", "What scores and covariances are worth",
                   [&] { DescribeCalibration(&options->calibration, list); });
}

}  // namespace

void DescribeLocalizer(LocalizerOptions* options, OptionList* list) {
  list->Add("num_threads", &options->num_threads,
            "Threads a query may use in localize and eval; serve takes server.threads_per_query");
  list->Add("seed", &options->seed, "Seed of everything random in a query");
  list->AddSection("prior", "Where a query searches",
                   [&] { DescribePrior(&options->prior, list); });
  list->AddSection("places", "Where a query without a prior searches",
                   [&] { DescribePlaces(&options->places, list); });
  list->AddSection("tiles", "Which tiles a query searches",
                   [&] { DescribeTiles(&options->tiles, list); });
  list->AddSection("matching", "Keypoints to landmarks",
                   [&] { DescribeMatching(&options->matching, list); });
  list->AddSection("voting", "Matches to candidates",
                   [&] { DescribeVoting(&options->voting, list); });
  list->AddSection("pose", "Candidates to poses", [&] { DescribePose(&options->pose, list); });
  list->AddSection("refinement", "More poses for queries without a convincing one",
                   [&] { DescribeRefinement(&options->refinement, list); });
  list->AddSection("answer", "When a pose is an answer",
                   [&] { DescribeAnswer(&options->answer, list); });
}

}  // namespace cairn
