#include "engine/index/hash_buckets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

namespace cairn {
namespace {

constexpr int kNoCap = 1'000'000;

std::vector<uint32_t> RandomHashes(size_t count, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<uint32_t> hashes(count);
  for (uint32_t& hash : hashes) {
    hash = static_cast<uint32_t>(random());
  }
  return hashes;
}

std::vector<uint32_t> ItemsOf(const TileLists& buckets, uint32_t bucket) {
  const auto items = buckets.Members(bucket);
  return {items.begin(), items.end()};
}

TEST(SortIntoBuckets, PutsEveryItemIntoItsBucketInOrder) {
  for (const int num_bits : {1, 2, 7, 12}) {
    const std::vector<uint32_t> hashes = RandomHashes(5'000, num_bits);
    const TileLists buckets = SortIntoBuckets(hashes, num_bits, kNoCap, 1);
    std::map<uint32_t, std::vector<uint32_t>> expected;
    for (uint32_t i = 0; i < hashes.size(); ++i) {
      expected[BucketOf(hashes[i], num_bits)].push_back(i);
    }
    ASSERT_EQ(buckets.num_lists(), size_t{1} << num_bits);
    for (uint32_t bucket = 0; bucket < buckets.num_lists(); ++bucket) {
      EXPECT_EQ(ItemsOf(buckets, bucket), expected[bucket]);
    }
  }
}

TEST(SortIntoBuckets, OfAFullBucketARandomSubsetComesFirst) {
  const TileLists buckets = SortIntoBuckets(std::vector<uint32_t>(1'000, 0), 4, 100, 1);
  std::vector<uint32_t> items = ItemsOf(buckets, 0);
  ASSERT_EQ(items.size(), 1'000u);
  EXPECT_TRUE(std::is_sorted(items.begin(), items.begin() + 100));
  EXPECT_TRUE(std::is_sorted(items.begin() + 100, items.end()));
  // Random: neither the first nor the last hundred, but spread over the thousand.
  EXPECT_LT(items.front(), 100u);
  EXPECT_GT(items[99], 900u);
  std::sort(items.begin(), items.end());
  EXPECT_EQ(std::adjacent_find(items.begin(), items.end()), items.end());
  EXPECT_THAT(ItemsOf(buckets, 1), ::testing::IsEmpty());
}

TEST(SortIntoBuckets, ABucketJustFullStaysInOrder) {
  const TileLists buckets = SortIntoBuckets(std::vector<uint32_t>(100, ~uint32_t{0}), 4, 100, 1);
  const std::vector<uint32_t> items = ItemsOf(buckets, 15);
  EXPECT_EQ(items.size(), 100u);
  EXPECT_TRUE(std::is_sorted(items.begin(), items.end()));
}

TEST(SortIntoBuckets, TheSubsetDependsOnTheSeedAlone) {
  const std::vector<uint32_t> hashes(1'000, 0);
  EXPECT_EQ(SortIntoBuckets(hashes, 4, 100, 1), SortIntoBuckets(hashes, 4, 100, 1));
  EXPECT_NE(SortIntoBuckets(hashes, 4, 100, 1), SortIntoBuckets(hashes, 4, 100, 2));
}

TEST(SortIntoBuckets, NothingGivesEmptyBuckets) {
  const TileLists buckets = SortIntoBuckets({}, 1, 100, 1);
  EXPECT_THAT(ItemsOf(buckets, 0), ::testing::IsEmpty());
  EXPECT_THAT(ItemsOf(buckets, 1), ::testing::IsEmpty());
}

}  // namespace
}  // namespace cairn
