#include "engine/matching/hit_collector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <utility>
#include <vector>

#include "core/error.h"
#include "engine/matching/simple_tile.h"

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

class HitCollectorTest : public ::testing::Test {
 protected:
  HitCollectorTest() : scale_(*testing::LatticeCodebook()) {}

  const ByteScale scale_;
  const DescriptorMatrix queries_ = DescriptorMatrix::Zero(3, 4);
  const std::vector<double> max_distances_ = {1.0, 2.0, 0.5};
};

TEST_F(HitCollectorTest, OrdersByQueryThenByArrival) {
  HitCollector collector(scale_, {queries_, max_distances_});
  collector.Add(2, 7, 10);
  collector.Add(0, 9, 30);
  collector.Add(2, 3, 20);
  collector.Add(0, 1, 5);
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
  collector.Add(2, 3, 20);
  collector.Add(0, 1, 5);
  std::vector<DescriptorHit> hits = {{1, 9, 0.0f}};
  collector.MoveTo(&hits);
  EXPECT_THAT(Pairs(hits), ElementsAre(std::pair(1, 9), std::pair(0, 1), std::pair(2, 3)));
}

TEST_F(HitCollectorTest, AReceiverGetsTheHitsAndLowersTheBound) {
  class Receiver : public HitReceiver {
   public:
    float Take(const DescriptorHit& hit) override {
      hits.push_back(hit);
      return max_sq_distance;
    }
    std::vector<DescriptorHit> hits;
    float max_sq_distance = std::numeric_limits<float>::infinity();
  } receiver;
  HitCollector collector(
      scale_, {.queries = queries_, .max_distances = max_distances_, .receiver = &receiver});
  const int32_t before = collector.max_sq_steps(1);
  collector.Add(1, 7, 100);
  EXPECT_EQ(collector.max_sq_steps(1), before);
  receiver.max_sq_distance = 50.0f * scale_.step() * scale_.step();
  collector.Add(1, 8, 60);
  EXPECT_GE(collector.max_sq_steps(1), 50);  // What is just useful must pass.
  EXPECT_LE(collector.max_sq_steps(1), 51);
  EXPECT_EQ(collector.max_sq_steps(0), scale_.MaxSqSteps(max_distances_[0]));
  receiver.max_sq_distance = 80.0f * scale_.step() * scale_.step();
  collector.Add(1, 9, 10);
  EXPECT_LE(collector.max_sq_steps(1), 51);  // Never rises.
  EXPECT_THAT(Pairs(receiver.hits), ElementsAre(std::pair(1, 7), std::pair(1, 8), std::pair(1, 9)));
  EXPECT_FLOAT_EQ(receiver.hits[1].sq_distance, 60.0f * scale_.step() * scale_.step());
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
