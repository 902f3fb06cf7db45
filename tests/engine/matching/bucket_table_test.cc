#include "engine/matching/bucket_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

namespace cairn {
namespace {

constexpr int kNoCap = 1'000'000;

std::vector<uint64_t> RandomHashes(size_t count, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<uint64_t> hashes(count);
  for (uint64_t& hash : hashes) {
    hash = random();
  }
  return hashes;
}

std::vector<uint32_t> ItemsOf(const BucketTable& table, uint32_t bucket) {
  const auto items = table.Items(bucket);
  return {items.begin(), items.end()};
}

TEST(BucketTable, HoldsEveryItemInItsBucketInOrder) {
  for (const int num_bits : {1, 2, 7, 12}) {
    const std::vector<uint64_t> hashes = RandomHashes(5'000, num_bits);
    BucketTable::Scratch scratch;
    const BucketTable table(hashes, num_bits, kNoCap, 1, &scratch);
    std::map<uint32_t, std::vector<uint32_t>> expected;
    for (uint32_t i = 0; i < hashes.size(); ++i) {
      expected[static_cast<uint32_t>(hashes[i] >> (64 - num_bits))].push_back(i);
    }
    for (uint32_t bucket = 0; bucket < uint32_t{1} << num_bits; ++bucket) {
      EXPECT_EQ(ItemsOf(table, bucket), expected[bucket]);
    }
  }
}

TEST(BucketTable, KeepsAtMostTheCapOfAFullBucket) {
  BucketTable::Scratch scratch;
  const BucketTable table(std::vector<uint64_t>(1'000, 0), 4, 100, 1, &scratch);
  const std::vector<uint32_t> items = ItemsOf(table, 0);
  EXPECT_EQ(items.size(), 100u);
  EXPECT_TRUE(std::is_sorted(items.begin(), items.end()));
  EXPECT_EQ(std::adjacent_find(items.begin(), items.end()), items.end());
  // Random: neither the first nor the last hundred, but spread over the thousand.
  EXPECT_LT(items.front(), 100u);
  EXPECT_GT(items.back(), 900u);
  EXPECT_THAT(table.Items(1), ::testing::IsEmpty());
}

TEST(BucketTable, ABucketJustFullIsKeptWhole) {
  BucketTable::Scratch scratch;
  const BucketTable table(std::vector<uint64_t>(100, ~uint64_t{0}), 4, 100, 1, &scratch);
  EXPECT_EQ(table.Items(15).size(), 100u);
}

TEST(BucketTable, SubsetDependsOnTheSeedAlone) {
  const std::vector<uint64_t> hashes(1'000, 0);
  BucketTable::Scratch scratch, other_scratch;
  const BucketTable a(hashes, 4, 100, 1, &scratch);
  const BucketTable b(hashes, 4, 100, 2, &scratch);
  const BucketTable again(hashes, 4, 100, 1, &other_scratch);
  EXPECT_EQ(ItemsOf(a, 0), ItemsOf(again, 0));
  EXPECT_NE(ItemsOf(a, 0), ItemsOf(b, 0));
}

TEST(BucketTable, OfNothingIsEmpty) {
  BucketTable::Scratch scratch;
  const BucketTable table({}, 1, 100, 1, &scratch);
  EXPECT_THAT(table.Items(0), ::testing::IsEmpty());
  EXPECT_THAT(table.Items(1), ::testing::IsEmpty());
}

}  // namespace
}  // namespace cairn
