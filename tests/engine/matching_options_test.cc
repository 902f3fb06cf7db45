#include "engine/matching/matching_options.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "core/error.h"
#include "engine/tiles/tiles_options.h"
#include "storage/codebook/distance_statistics.h"
#include "support/refused_options.h"

namespace cairn {
namespace {

TEST(MatchingOptions, DefaultsAreValid) {
  EXPECT_NO_THROW(MatchingOptions().Validate());
  EXPECT_NO_THROW(TilesOptions().Validate());
}

TEST(MatchingOptions, NameTheFieldThatMakesNoSense) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<testing::SpoiledField<MatchingOptions>> cases = {
      {"num_grids", [](auto* options) { options->index.grids.num_grids = 0; }},
      {"num_hashed_dims", [](auto* options) { options->index.grids.num_hashed_dims = 129; }},
      {"cell_width_sigmas", [=](auto* options) { options->index.grids.cell_width_sigmas = nan; }},
      {"num_probes", [](auto* options) { options->index.grids.num_probes = 129; }},
      {"max_candidates_per_cell",
       [](auto* options) { options->index.grids.max_candidates_per_cell = 0; }},
      {"lists.num_lists", [](auto* options) { options->index.lists.num_lists = 0; }},
      {"lists.num_probes", [](auto* options) { options->index.lists.num_probes = 0; }},
      {"lists.num_iterations", [](auto* options) { options->index.lists.num_iterations = -1; }},
      {"num_reference_words", [](auto* options) { options->index.num_reference_words = -1; }},
      {"num_reference_words",
       [](auto* options) { options->distance_filter = DistanceFilter::kWordRatio; }},
      {"max_word_ratio", [](auto* options) { options->max_word_ratio = 0.0; }},
      {"max_position_excess_sigmas",
       [=](auto* options) { options->max_position_excess_sigmas = nan; }},
      {"max_neighbors", [](auto* options) { options->max_neighbors = 0; }},
      {"max_keypoints_of_landmark", [](auto* options) { options->max_keypoints_of_landmark = 0; }},
      {"distance_quantile", [](auto* options) { options->distance_quantile = 1.0; }},
      {"orientation_weight", [](auto* options) { options->orientation_weight = -1.0; }},
      {"position_weight", [=](auto* options) { options->position_weight = nan; }},
      {"viewing_distance_m", [](auto* options) { options->viewing_distance_m = -1.0; }},
      {"max_orientation_difference_rad",
       [](auto* options) { options->max_orientation_difference_rad = 4.0; }},
  };
  testing::ExpectRefused(MatchingOptions(), cases);
}

TEST(TilesOptions, RefuseNonsense) {
  EXPECT_THROW(TilesOptions{.max_tiles = 0}.Validate(), Error);
  EXPECT_THROW(TilesOptions{.height_margin_m = -1.0}.Validate(), Error);
}

TEST(SameLandmarkDistance, InterpolatesBetweenQuantiles) {
  Codebook codebook;
  for (int i = 1; i <= 19; ++i) {
    codebook.same_landmark_distance_quantiles.push_back(static_cast<float>(i));
  }
  EXPECT_NEAR(SameLandmarkDistance(codebook, 0.5), 10.0, 1e-6);
  EXPECT_NEAR(SameLandmarkDistance(codebook, 0.925), 18.5, 1e-6);
  EXPECT_NEAR(SameLandmarkDistance(codebook, 0.05), 1.0, 1e-6);
  EXPECT_NEAR(SameLandmarkDistance(codebook, 0.95), 19.0, 1e-6);
  EXPECT_NEAR(SameLandmarkDistance(codebook, 1.0), 19.0, 1e-6);
  EXPECT_NEAR(SameLandmarkDistance(codebook, 0.0), 1.0, 1e-6);
}

TEST(SameLandmarkDistance, RefusesACodebookWithoutStatistics) {
  EXPECT_THROW(SameLandmarkDistance(Codebook(), 0.5), Error);
}

}  // namespace
}  // namespace cairn
