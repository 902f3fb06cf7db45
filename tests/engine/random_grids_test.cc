#include "engine/index/random_grids.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <span>
#include <tuple>
#include <utility>

#include "engine/index/inverted_lists.h"
#include "engine/index/shared_visits.h"
#include "engine/real_sift.h"
#include "engine/synthetic_descriptors.h"
#include "storage/codebook/distance_statistics.h"
#include "support/test_data.h"

namespace cairn {
namespace {

using testing::ExhaustiveHits;
using testing::LandmarkRecall;
using testing::MakeSyntheticDescriptors;
using testing::Sorted;
using testing::SyntheticDescriptors;
using testing::Threshold;

std::vector<DescriptorHit> GridHits(const SyntheticDescriptors& data,
                                    const RandomGridsOptions& options) {
  std::vector<DescriptorHit> hits;
  RandomGrids(*data.codebook, data.codes, options)
      .RangeSearch(data.queries, Threshold(data), &hits);
  return hits;
}

TEST(RandomGrids, RecallsNearlyWhatExhaustiveSearchDoes) {
  const SyntheticDescriptors data =
      MakeSyntheticDescriptors({.num_landmarks = 20'000, .num_queries = 1'000});
  const double exhaustive = LandmarkRecall(data, ExhaustiveHits(data), 4);
  EXPECT_GT(exhaustive, 0.85);
  EXPECT_GT(LandmarkRecall(data, GridHits(data, {}), 4), 0.93 * exhaustive);
}

TEST(RandomGrids, ComputesAFractionOfTheDistances) {
  const SyntheticDescriptors data =
      MakeSyntheticDescriptors({.num_landmarks = 20'000, .num_queries = 200});
  std::vector<DescriptorHit> hits;
  const int64_t num_distances =
      RandomGrids(*data.codebook, data.codes, {}).RangeSearch(data.queries, 0.1, &hits);
  EXPECT_GT(num_distances, static_cast<int64_t>(hits.size()));
  EXPECT_LT(num_distances, 200 * 40'000 / 20);
}

TEST(RandomGrids, SameSeedGivesTheSameHitsAnotherSeedOthers) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({});
  const auto hits = Sorted(GridHits(data, {.seed = 1}));
  EXPECT_EQ(hits, Sorted(GridHits(data, {.seed = 1})));
  EXPECT_NE(hits, Sorted(GridHits(data, {.seed = 2})));
}

TEST(RandomGrids, MoreGridsAndProbesRecallMore) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 10'000});
  const size_t few = GridHits(data, {.num_grids = 2, .num_probes = 1}).size();
  const size_t more_grids = GridHits(data, {.num_grids = 8, .num_probes = 1}).size();
  const size_t more_probes = GridHits(data, {.num_grids = 2, .num_probes = 8}).size();
  EXPECT_GT(more_grids, few);
  EXPECT_GT(more_probes, few);
}

TEST(RandomGrids, ACellGivesAtMostItsCapOfCandidates) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 2'000});
  // Cells so wide that all 4,000 descriptors share one.
  const RandomGridsOptions options{.num_grids = 1,
                                   .num_hashed_dims = 1,
                                   .cell_width_sigmas = 1000.0,
                                   .num_probes = 1,
                                   .max_candidates_per_cell = 100};
  std::vector<DescriptorHit> hits;
  const int64_t num_distances = RandomGrids(*data.codebook, data.codes, options)
                                    .RangeSearch(data.queries.topRows(1), 1e3, &hits);
  EXPECT_EQ(num_distances, 100);
  EXPECT_EQ(hits.size(), 100u);
}

// A place is one of the order of the first grid, whichever grid has found it.
TEST(RandomGrids, GiveAReceiverTheirPlaces) {
  class Receiver : public HitReceiver {
   public:
    explicit Receiver(std::span<const uint32_t> order) : order_(order) {}
    float Take(const HitRun& run) override {
      for (size_t i = 0; i < run.hits.size(); ++i) {
        EXPECT_EQ(order_[run.hits[i].row], run[i].descriptor_idx);
        hits.push_back(run[i]);
      }
      return std::numeric_limits<float>::infinity();
    }
    std::vector<DescriptorHit> hits;

   private:
    std::span<const uint32_t> order_;
  };
  const SyntheticDescriptors data = MakeSyntheticDescriptors({});
  const RandomGrids grids(*data.codebook, data.codes, {.num_grids = 4, .num_probes = 4});
  Receiver receiver(grids.order());
  const std::vector<double> max_distances(data.queries.rows(), Threshold(data));
  grids.Search({.queries = data.queries, .max_distances = max_distances, .receiver = &receiver},
               nullptr);
  auto found = Sorted(receiver.hits);
  const auto expected = Sorted(GridHits(data, {.num_grids = 4, .num_probes = 4}));
  EXPECT_GT(found.size(), expected.size());  // Some are found in several grids.
  found.erase(std::unique(found.begin(), found.end()), found.end());
  EXPECT_EQ(found, expected);
}

// As for the tiles of a query: one codebook, as many buckets in two of them and fewer in the third.
TEST(RandomGrids, VisitsThatTilesShareChangeNothing) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 8'000});
  const std::span<const uint8_t> codes = data.codes;
  const std::vector<double> max_distances(data.queries.rows(), Threshold(data));
  SharedVisits visits;
  const size_t few = codes.size() / 16;
  for (const auto& part : {codes, codes.subspan(few), codes.first(few)}) {
    const RandomGrids grids(*data.codebook, part, {});
    std::vector<DescriptorHit> shared, alone;
    const SearchRequest request = {.queries = data.queries, .max_distances = max_distances};
    SearchRequest sharing = request;
    sharing.shared_visits = &visits;
    EXPECT_EQ(grids.Search(sharing, &shared), grids.Search(request, &alone));
    EXPECT_FALSE(alone.empty());
    EXPECT_EQ(Sorted(shared), Sorted(alone));
  }
}

// As tiles store them.
TEST(RandomGrids, RowsInTheOrderOfListsChangeNoHit) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({});
  const TileLists lists = MakeTileLists(*data.codebook, data.codes, {.num_lists = 64});
  const LargeVector<uint8_t> ordered = OrderCodes(data.codes, data.codebook->num_subspaces, lists);
  for (const int num_grids : {1, 3}) {
    const RandomGridsOptions options = {.num_grids = num_grids};
    const RandomGrids grids(*data.codebook, ordered, options, BuildExtent::kWhole, lists.members);
    std::vector<DescriptorHit> hits;
    grids.RangeSearch(data.queries, Threshold(data), &hits);
    EXPECT_FALSE(hits.empty());
    EXPECT_EQ(Sorted(hits), Sorted(GridHits(data, options)));
  }
}

TEST(RandomGrids, WorkInAnyDimension) {
  for (const auto& [dim, num_subspaces] :
       std::vector<std::pair<int, int>>{{4, 2}, {8, 8}, {20, 5}, {32, 8}, {128, 16}}) {
    const SyntheticDescriptors data = MakeSyntheticDescriptors(
        {.num_landmarks = 1'000, .num_queries = 200, .dim = dim, .num_subspaces = num_subspaces});
    const double exhaustive = LandmarkRecall(data, ExhaustiveHits(data), 4);
    EXPECT_GT(LandmarkRecall(data, GridHits(data, {}), 4), 0.7 * exhaustive) << dim;
  }
}

TEST(RandomGrids, EqualDescriptorsWithoutSpreadDoNotBreakTheCellWidth) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 100});
  Codebook codebook = *data.codebook;
  std::fill(codebook.same_landmark_distance_quantiles.begin(),
            codebook.same_landmark_distance_quantiles.end(), 0.0f);
  std::vector<DescriptorHit> hits;
  const DescriptorMatrix query = DescriptorCodec(data.codebook).Decode(data.codes.data(), 1);
  RandomGrids(codebook, data.codes, {}).RangeSearch(query, 0.01, &hits);
  EXPECT_FALSE(hits.empty());
}

TEST(RandomGrids, RecallNearNeighborsOfRealSift) {
  CAIRN_SKIP_WITHOUT_DATA("ann_bigann10k/base10k.u8bin");
  const SyntheticDescriptors data = testing::RealSift(
      testing::TestDataDir() / "ann_bigann10k/base10k.u8bin", /*num_queries=*/1'000);
  const auto all = Sorted(ExhaustiveHits(data));
  const auto found = Sorted(GridHits(data, {}));
  EXPECT_GT(static_cast<double>(found.size()) / static_cast<double>(all.size()), 0.6);
}

}  // namespace
}  // namespace cairn
