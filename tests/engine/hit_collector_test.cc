#include "engine/index/hit_collector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <utility>
#include <vector>

#include "core/error.h"
#include "engine/simple_tile.h"

namespace cairn {
namespace {

using ::testing::ElementsAre;

std::vector<std::pair<uint32_t, uint32_t>> Pairs(const std::vector<DescriptorHit>& hits) {
  std::vector<std::pair<uint32_t, uint32_t>> pairs;
  for (const DescriptorHit& hit : hits) {
    pairs.emplace_back(hit.query_idx, hit.descriptor_idx);
  }
  return pairs;
}

void AddHit(uint32_t query_idx, const BlockHit& hit, HitCollector* collector) {
  collector->Add(query_idx, {&hit, 1});
}

class HitCollectorTest : public ::testing::Test {
 protected:
  HitCollectorTest() : scale_(*testing::LatticeCodebook()) {}

  const ByteScale scale_;
  const DescriptorMatrix queries_ = DescriptorMatrix::Zero(3, 4);
  const std::vector<double> max_distances_ = {1.0, 2.0, 0.5};
};

TEST_F(HitCollectorTest, OrdersByQueryThenByArrival) {
  HitCollector collector(scale_, {queries_, max_distances_});
  AddHit(2, {7, 10}, &collector);
  AddHit(0, {9, 30}, &collector);
  AddHit(2, {3, 20}, &collector);
  AddHit(0, {1, 5}, &collector);
  std::vector<DescriptorHit> hits;
  collector.MoveTo(&hits);
  EXPECT_THAT(Pairs(hits),
              ElementsAre(std::pair(0, 9), std::pair(0, 1), std::pair(2, 7), std::pair(2, 3)));
  EXPECT_FLOAT_EQ(hits[0].sq_distance, 30.0f * scale_.step() * scale_.step());
}

TEST_F(HitCollectorTest, EveryQueryHasItsOwnDistance) {
  const HitCollector collector(scale_, {queries_, max_distances_});
  for (uint32_t query = 0; query < 3; ++query) {
    EXPECT_EQ(collector.max_sq_steps(query), scale_.MaxSqSteps(max_distances_[query]));
  }
}

TEST_F(HitCollectorTest, AppendsToWhatWasThere) {
  HitCollector collector(scale_, {queries_, max_distances_});
  AddHit(2, {3, 20}, &collector);
  AddHit(0, {1, 5}, &collector);
  std::vector<DescriptorHit> hits = {{1, 9, 0.0f}};
  collector.MoveTo(&hits);
  EXPECT_THAT(Pairs(hits), ElementsAre(std::pair(1, 9), std::pair(0, 1), std::pair(2, 3)));
}

TEST_F(HitCollectorTest, AReceiverGetsTheHitsAndLowersTheBound) {
  class Receiver : public HitReceiver {
   public:
    float Take(const HitRun& run) override {
      for (size_t i = 0; i < run.hits.size(); ++i) {
        hits.push_back(run[i]);
      }
      return max_sq_distance;
    }
    std::vector<DescriptorHit> hits;
    float max_sq_distance = std::numeric_limits<float>::infinity();
  } receiver;
  HitCollector collector(
      scale_, {.queries = queries_, .max_distances = max_distances_, .receiver = &receiver});
  const int32_t before = collector.max_sq_steps(1);
  AddHit(1, {7, 100}, &collector);
  EXPECT_EQ(collector.max_sq_steps(1), before);
  receiver.max_sq_distance = 50.0f * scale_.step() * scale_.step();
  AddHit(1, {8, 60}, &collector);
  EXPECT_GE(collector.max_sq_steps(1), 50);  // What is just useful must pass.
  EXPECT_LE(collector.max_sq_steps(1), 51);
  EXPECT_EQ(collector.max_sq_steps(0), scale_.MaxSqSteps(max_distances_[0]));
  receiver.max_sq_distance = 80.0f * scale_.step() * scale_.step();
  AddHit(1, {9, 10}, &collector);
  EXPECT_LE(collector.max_sq_steps(1), 51);  // Never rises.
  EXPECT_THAT(Pairs(receiver.hits), ElementsAre(std::pair(1, 7), std::pair(1, 8), std::pair(1, 9)));
  EXPECT_FLOAT_EQ(receiver.hits[1].sq_distance, 60.0f * scale_.step() * scale_.step());
}

TEST_F(HitCollectorTest, PlacesOfAnIndexAreDescriptorsInItsOrder) {
  const std::vector<uint32_t> order = {4, 2, 9};
  const std::vector<BlockHit> run = {{2, 10}, {0, 20}};
  HitCollector collector(scale_, {queries_, max_distances_});
  collector.Add(1, run, order);
  std::vector<DescriptorHit> hits;
  collector.MoveTo(&hits);
  EXPECT_THAT(Pairs(hits), ElementsAre(std::pair(1, 9), std::pair(1, 4)));
  EXPECT_FLOAT_EQ(hits[1].sq_distance, 20.0f * scale_.step() * scale_.step());
}

TEST_F(HitCollectorTest, AReceiverIsNotAskedAboutNothing) {
  class Receiver : public HitReceiver {
   public:
    float Take(const HitRun&) override {
      ADD_FAILURE() << "there are no hits";
      return 0.0f;
    }
  } receiver;
  HitCollector collector(
      scale_, {.queries = queries_, .max_distances = max_distances_, .receiver = &receiver});
  collector.Add(1, {});
  EXPECT_EQ(collector.max_sq_steps(1), scale_.MaxSqSteps(max_distances_[1]));
}

TEST_F(HitCollectorTest, NothingGivesNothing) {
  HitCollector collector(scale_, {queries_, max_distances_});
  std::vector<DescriptorHit> hits;
  collector.MoveTo(&hits);
  EXPECT_TRUE(hits.empty());
}

TEST_F(HitCollectorTest, RefusesQueriesOfAnotherDimension) {
  const DescriptorMatrix queries = DescriptorMatrix::Zero(3, 5);
  EXPECT_THROW(HitCollector(scale_, {queries, max_distances_}), Error);
}

}  // namespace
}  // namespace cairn
