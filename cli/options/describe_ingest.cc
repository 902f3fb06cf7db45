#include "cli/options/cairn_options.h"

namespace cairn {
namespace {

constexpr EnumName<AppearanceKind> kAppearanceNames[] = {{"kmeans", AppearanceKind::kKMeans},
                                                         {"kmedoids", AppearanceKind::kKMedoids},
                                                         {"random", AppearanceKind::kRandom}};

void DescribeCodebook(CodebookOptions* options, OptionList* list) {
  list->Add("projected_dim", &options->projected_dim, "Dimensions of a descriptor after PCA");
  list->Add("num_subspaces", &options->num_subspaces,
            "Bytes of a descriptor; has to divide projected_dim");
  list->Add("max_training_descriptors", &options->max_training_descriptors,
            "Most descriptors that the codebook is trained on");
  list->Add("seed", &options->seed, "Seed of the training");
}

void DescribeSelection(LandmarkSelectionOptions* options, OptionList* list) {
  list->Add("kind", &options->kind, kLandmarkSelectionNames,
            "observation_count keeps the most observed landmarks of each keyframe; coverage solves "
            "the paper's integer program");
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

}  // namespace

void DescribeIngest(IngestOptions* options, OptionList* list) {
  list->Add("max_sigma_m", &options->max_sigma_m,
            "Landmarks with a larger standard deviation of the position are dropped, meters");
  list->Add("max_reprojection_error_px", &options->max_reprojection_error_px,
            "Landmarks with a larger median reprojection error are dropped, pixels");
  list->AddSection("codebook",
                   "How descriptors are compressed; counts for the first session of a map only",
                   [&] { DescribeCodebook(&options->codebook, list); });
  list->AddSection("selection", "Which landmarks of a tile are kept",
                   [&] { DescribeSelection(&options->selection, list); });
  list->AddSection("appearance", "Which descriptors represent a landmark",
                   [&] { DescribeAppearance(&options->appearance, list); });
}

}  // namespace cairn
