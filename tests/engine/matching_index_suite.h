// Tests the contract of MatchingIndex. A test instantiates MatchingIndexTest with the kinds of
// index that it knows.
#ifndef CAIRN_TESTS_ENGINE_MATCHING_INDEX_SUITE_H_
#define CAIRN_TESTS_ENGINE_MATCHING_INDEX_SUITE_H_

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <set>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/large_vector.h"
#include "engine/index/byte_descriptors.h"
#include "engine/index/inverted_lists.h"
#include "engine/index/matching_index.h"
#include "engine/index_under_test.h"
#include "engine/synthetic_descriptors.h"
#include "storage/codebook/descriptor_codec.h"
#include "storage/codebook/distance_statistics.h"

namespace cairn {
namespace {

using testing::ExhaustiveHits;
using testing::HitTuple;
using testing::LandmarkRecall;
using testing::MakeSyntheticDescriptors;
using testing::Sorted;
using testing::SyntheticDescriptors;
using testing::Threshold;

class MatchingIndexTest : public ::testing::TestWithParam<testing::IndexUnderTest> {
 protected:
  static IndexOptions Options() { return GetParam().options; }
  // Settings at which nothing is missed.
  static IndexOptions CompleteOptions() { return GetParam().complete; }

  static std::unique_ptr<const MatchingIndex> Make(const SyntheticDescriptors& data,
                                                   const IndexOptions& options = Options()) {
    return MakeMatchingIndex(*data.codebook, data.codes, options);
  }

  static std::vector<DescriptorHit> Hits(const SyntheticDescriptors& data,
                                         const IndexOptions& options = Options()) {
    std::vector<DescriptorHit> hits;
    Make(data, options)->RangeSearch(data.queries, Threshold(data), &hits);
    return hits;
  }
};

TEST_P(MatchingIndexTest, RecallsNearlyWhatExhaustiveSearchDoes) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 5'000});
  const double exhaustive = LandmarkRecall(data, ExhaustiveHits(data), 4);
  EXPECT_GT(exhaustive, 0.85);
  EXPECT_GT(LandmarkRecall(data, Hits(data), 4), 0.9 * exhaustive);
}

TEST_P(MatchingIndexTest, FindsAllWhereItLooksEverywhere) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 2'000});
  EXPECT_EQ(Sorted(Hits(data, CompleteOptions())), Sorted(ExhaustiveHits(data)));
}

TEST_P(MatchingIndexTest, HitsAreExhaustiveHitsWithTheirExactDistancesOnceEach) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({});
  const auto found = Sorted(Hits(data));
  const auto all = Sorted(ExhaustiveHits(data));
  ASSERT_FALSE(found.empty());
  EXPECT_TRUE(std::includes(all.begin(), all.end(), found.begin(), found.end()));
  EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end());
}

TEST_P(MatchingIndexTest, HitsAreAppendedInOrderOfQuery) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({});
  std::vector<DescriptorHit> hits = {{1'000, 1, 1.0f}};
  Make(data)->RangeSearch(data.queries, Threshold(data), &hits);
  ASSERT_GT(hits.size(), 2u);
  EXPECT_EQ(hits.front().query_idx, 1'000u);
  EXPECT_TRUE(std::is_sorted(hits.begin() + 1, hits.end(), [](const auto& a, const auto& b) {
    return a.query_idx < b.query_idx;
  }));
}

TEST_P(MatchingIndexTest, EveryQueryHasItsOwnDistance) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({});
  std::vector<double> max_distances(data.queries.rows(), Threshold(data));
  for (size_t query = 0; query < max_distances.size(); query += 2) {
    max_distances[query] = 0.0;
  }
  std::vector<DescriptorHit> hits;
  Make(data, CompleteOptions())->Search({data.queries, max_distances}, &hits);
  std::vector<DescriptorHit> expected = ExhaustiveHits(data);
  std::erase_if(expected, [](const DescriptorHit& hit) {
    return hit.query_idx % 2 == 0 && hit.sq_distance > 0.0f;
  });
  EXPECT_EQ(Sorted(hits), Sorted(expected));
}

// Keeps the nearest hits of each query, and asks for no farther ones than these.
class NearestReceiver : public HitReceiver {
 public:
  explicit NearestReceiver(size_t max_hits) : max_hits_(max_hits) {}

  float Take(const HitRun& run) override {
    float max_sq_distance = 0.0f;
    for (size_t i = 0; i < run.hits.size(); ++i) {
      max_sq_distance = Take(run[i]);
    }
    return max_sq_distance;
  }
  float Take(const DescriptorHit& hit) {
    auto& nearest = nearest_[hit.query_idx];
    nearest.emplace(hit.sq_distance, hit.descriptor_idx);
    if (nearest.size() > max_hits_) {
      nearest.erase(std::prev(nearest.end()));
    }
    return nearest.size() < max_hits_ ? std::numeric_limits<float>::infinity()
                                      : nearest.rbegin()->first;
  }

  std::vector<HitTuple> Kept() const {
    std::vector<HitTuple> kept;
    for (const auto& [query, nearest] : nearest_) {
      for (const auto& [sq_distance, descriptor] : nearest) {
        kept.emplace_back(query, descriptor, sq_distance);
      }
    }
    std::sort(kept.begin(), kept.end());
    return kept;
  }

 private:
  size_t max_hits_;
  std::map<uint32_t, std::set<std::pair<float, uint32_t>>> nearest_;
};

TEST_P(MatchingIndexTest, AFallingBoundLosesNoneOfTheNearest) {
  constexpr size_t kMaxHits = 5;
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_queries = 100});
  const std::vector<double> max_distances(data.queries.rows(),
                                          std::numeric_limits<double>::infinity());
  NearestReceiver found(kMaxHits), expected(kMaxHits);
  Make(data, CompleteOptions())
      ->Search({.queries = data.queries, .max_distances = max_distances, .receiver = &found},
               nullptr);
  std::vector<DescriptorHit> all;
  ByteDescriptors(*data.codebook, data.codes).Search({data.queries, max_distances}, &all);
  for (const DescriptorHit& hit : all) {
    expected.Take(hit);
  }
  EXPECT_EQ(found.Kept(), expected.Kept());
}

TEST_P(MatchingIndexTest, SameOptionsGiveTheSameHits) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({});
  EXPECT_EQ(Sorted(Hits(data)), Sorted(Hits(data)));
}

TEST_P(MatchingIndexTest, HitsDoNotDependOnTheOtherQueries) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_queries = 50});
  const auto index = Make(data);
  std::vector<DescriptorHit> batch, single;
  const int64_t num_distances = index->RangeSearch(data.queries, Threshold(data), &batch);
  int64_t sum_of_distances = 0;
  for (uint32_t query = 0; query < 50; ++query) {
    const auto begin = static_cast<ptrdiff_t>(single.size());
    sum_of_distances += index->RangeSearch(data.queries.row(query), Threshold(data), &single);
    std::for_each(single.begin() + begin, single.end(),
                  [query](DescriptorHit& hit) { hit.query_idx = query; });
  }
  EXPECT_EQ(Sorted(batch), Sorted(single));
  EXPECT_EQ(num_distances, sum_of_distances);
}

TEST_P(MatchingIndexTest, WorksInAnyDimension) {
  for (const auto& [dim, num_subspaces] :
       std::vector<std::pair<int, int>>{{1, 1}, {4, 2}, {8, 8}, {20, 5}, {32, 8}, {128, 16}}) {
    const SyntheticDescriptors data = MakeSyntheticDescriptors(
        {.num_landmarks = 1'000, .num_queries = 200, .dim = dim, .num_subspaces = num_subspaces});
    const auto all = Sorted(ExhaustiveHits(data));
    const auto found = Sorted(Hits(data, CompleteOptions()));
    EXPECT_GE(found.size(), all.size()) << dim;
  }
}

TEST_P(MatchingIndexTest, IndexesNothing) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({});
  const auto index = MakeMatchingIndex(*data.codebook, {}, Options());
  std::vector<DescriptorHit> hits;
  EXPECT_EQ(index->RangeSearch(data.queries, 1e3, &hits), 0);
  EXPECT_THAT(hits, ::testing::IsEmpty());
}

TEST_P(MatchingIndexTest, IndexesOneDescriptor) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({});
  const std::span<const uint8_t> first_code(data.codes.data(), 8);
  const auto index = MakeMatchingIndex(*data.codebook, first_code, Options());
  const DescriptorMatrix query = DescriptorCodec(data.codebook).Decode(data.codes.data(), 1);
  std::vector<DescriptorHit> hits;
  index->RangeSearch(query, Threshold(data), &hits);
  ASSERT_EQ(hits.size(), 1u);
  EXPECT_EQ(hits[0].descriptor_idx, 0u);
}

TEST_P(MatchingIndexTest, IndexesEqualDescriptors) {
  SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 40});
  for (size_t i = 0; i < data.codes.size(); ++i) {
    data.codes[i] = data.codes[i % 8];
  }
  data.queries = DescriptorCodec(data.codebook).Decode(data.codes.data(), 1);
  EXPECT_EQ(Hits(data).size(), 80u);
}

TEST_P(MatchingIndexTest, NoQueriesGiveNoHits) {
  const auto index = Make(MakeSyntheticDescriptors({}));
  std::vector<DescriptorHit> hits;
  EXPECT_EQ(index->RangeSearch(DescriptorMatrix(0, 16), 1.0, &hits), 0);
  EXPECT_THAT(hits, ::testing::IsEmpty());
}

TEST_P(MatchingIndexTest, ExtremeQueriesMatchNothing) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({});
  DescriptorMatrix queries = DescriptorMatrix::Constant(3, 16, 1e30f);
  queries.row(1) *= -1.0f;
  queries.row(2).setConstant(std::numeric_limits<float>::quiet_NaN());
  std::vector<DescriptorHit> hits;
  Make(data)->RangeSearch(queries, Threshold(data), &hits);
  EXPECT_THAT(hits, ::testing::IsEmpty());
}

TEST_P(MatchingIndexTest, RefusesQueriesOfAnotherDimension) {
  const auto index = Make(MakeSyntheticDescriptors({.num_landmarks = 100}));
  std::vector<DescriptorHit> hits;
  EXPECT_THROW(index->RangeSearch(DescriptorMatrix::Zero(1, 8), 1.0, &hits), Error);
}

TEST_P(MatchingIndexTest, MemoryGrowsWithTheDescriptors) {
  const auto small = Make(MakeSyntheticDescriptors({.num_landmarks = 1'000}));
  const auto large = Make(MakeSyntheticDescriptors({.num_landmarks = 8'000}));
  constexpr size_t kBytesPerDescriptor = 16;
  EXPECT_GE(small->MemoryBytes(), 2'000 * kBytesPerDescriptor);
  EXPECT_GE(large->MemoryBytes(), small->MemoryBytes() + 14'000 * kBytesPerDescriptor);
}

TEST_P(MatchingIndexTest, ItsOrderHoldsEveryDescriptorOnce) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 2'000});
  const auto index = Make(data);
  std::vector<uint32_t> order(index->order().begin(), index->order().end());
  if (!order.empty()) {
    std::sort(order.begin(), order.end());
    std::vector<uint32_t> all(data.codes.size() / data.codebook->num_subspaces);
    std::iota(all.begin(), all.end(), 0u);
    EXPECT_EQ(order, all);
  }
}

TEST_P(MatchingIndexTest, AReceiverGetsWhatWouldBeReturned) {
  class Receiver : public HitReceiver {
   public:
    float Take(const HitRun& run) override {
      for (size_t i = 0; i < run.hits.size(); ++i) {
        hits.push_back(run[i]);
      }
      return std::numeric_limits<float>::infinity();
    }
    std::vector<DescriptorHit> hits;
  } receiver;
  const SyntheticDescriptors data = MakeSyntheticDescriptors({});
  const std::vector<double> max_distances(data.queries.rows(), Threshold(data));
  Make(data)->Search(
      {.queries = data.queries, .max_distances = max_distances, .receiver = &receiver}, nullptr);
  auto found = Sorted(receiver.hits);
  found.erase(std::unique(found.begin(), found.end()), found.end());
  EXPECT_EQ(found, Sorted(Hits(data)));
}

TEST_P(MatchingIndexTest, PartsAddToWhatIsFoundUntilItIsAll) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 2'000});
  const auto whole = Make(data);
  EXPECT_TRUE(whole->is_complete());
  const auto index =
      MakeMatchingIndex(*data.codebook, data.codes, Options(), {}, BuildExtent::kFirstPart);
  EXPECT_EQ(index->MemoryBytes(), whole->MemoryBytes());
  const auto find = [&] {
    std::vector<DescriptorHit> hits;
    index->RangeSearch(data.queries, Threshold(data), &hits);
    return Sorted(hits);
  };
  std::vector<HitTuple> found = find();
  EXPECT_FALSE(found.empty());
  while (!index->is_complete()) {
    index->BuildPart();
    const std::vector<HitTuple> more = find();
    EXPECT_GT(more.size(), found.size());
    EXPECT_TRUE(std::includes(more.begin(), more.end(), found.begin(), found.end()));
    found = more;
  }
  EXPECT_EQ(found, Sorted(Hits(data)));
  index->BuildPart();
  EXPECT_EQ(find(), found);
}

TEST_P(MatchingIndexTest, ThreadsBuildAndSearchAtOnce) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({});
  const auto index =
      MakeMatchingIndex(*data.codebook, data.codes, Options(), {}, BuildExtent::kFirstPart);
  std::vector<std::vector<DescriptorHit>> found(4);
  {
    std::vector<std::jthread> threads;
    for (std::vector<DescriptorHit>& hits : found) {
      threads.emplace_back([&] {
        do {
          index->BuildPart();
          hits.clear();
          index->RangeSearch(data.queries, Threshold(data), &hits);
        } while (!index->is_complete());
        hits.clear();
        index->RangeSearch(data.queries, Threshold(data), &hits);
      });
    }
  }
  for (const std::vector<DescriptorHit>& hits : found) {
    EXPECT_EQ(Sorted(hits), Sorted(Hits(data)));
  }
}

TEST_P(MatchingIndexTest, FindsLessWhenToldToStop) {
  const SyntheticDescriptors data =
      MakeSyntheticDescriptors({.num_landmarks = 2'000, .num_queries = 200});
  const auto index = Make(data);
  const auto all = Sorted(Hits(data));
  const std::vector<double> max_distances(data.queries.rows(), Threshold(data));
  // Stops at the n-th question.
  const auto search = [&](int n, std::vector<HitTuple>* found) {
    std::vector<DescriptorHit> hits;
    int num_questions = 0;
    const int64_t num_distances =
        index->Search({.queries = data.queries,
                       .max_distances = max_distances,
                       .should_stop = [&] { return ++num_questions >= n; }},
                      &hits);
    *found = Sorted(hits);
    return num_distances;
  };
  std::vector<HitTuple> found;
  EXPECT_EQ(search(1, &found), 0);
  EXPECT_THAT(found, ::testing::IsEmpty());
  const int64_t num_distances = search(3, &found);
  EXPECT_GT(num_distances, 0);
  EXPECT_FALSE(found.empty());
  EXPECT_LT(found.size(), all.size());
  EXPECT_TRUE(std::includes(all.begin(), all.end(), found.begin(), found.end()));
  EXPECT_GT(search(1'000'000, &found), num_distances);
  EXPECT_EQ(found, all);
}

TEST_P(MatchingIndexTest, ListsThatWereMadeBeforeChangeNothing) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({});
  TileLists lists = MakeTileLists(*data.codebook, data.codes, Options().lists);
  std::vector<DescriptorHit> hits;
  MakeMatchingIndex(*data.codebook, data.codes, Options(), std::move(lists))
      ->RangeSearch(data.queries, Threshold(data), &hits);
  EXPECT_EQ(Sorted(hits), Sorted(Hits(data)));
}

}  // namespace
}  // namespace cairn

#endif  // CAIRN_TESTS_ENGINE_MATCHING_INDEX_SUITE_H_
