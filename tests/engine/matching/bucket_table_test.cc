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

// Any function of the item.
uint32_t SketchOf(uint32_t item) { return item * 7 + 3; }

BucketTable MakeTable(const std::vector<uint64_t>& hashes, int num_bits, int max_items,
                      uint64_t seed) {
  std::vector<uint32_t> sketches;
  for (uint32_t i = 0; i < hashes.size(); ++i) {
    sketches.push_back(SketchOf(i));
  }
  BucketTable::Scratch scratch;
  return BucketTable(hashes, sketches, num_bits, max_items, seed, &scratch);
}

// Expects each item to have its own sketch.
std::vector<uint32_t> ItemsOf(const BucketTable& table, uint32_t bucket) {
  const auto [sketches, items] = table[bucket];
  EXPECT_EQ(sketches.size(), items.size());
  for (size_t i = 0; i < items.size(); ++i) {
    EXPECT_EQ(sketches[i], SketchOf(items[i]));
  }
  return {items.begin(), items.end()};
}

TEST(BucketTable, HoldsEveryItemInItsBucketInOrder) {
  for (const int num_bits : {1, 2, 7, 12}) {
    const std::vector<uint64_t> hashes = RandomHashes(5'000, num_bits);
    const BucketTable table = MakeTable(hashes, num_bits, kNoCap, 1);
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
  const BucketTable table = MakeTable(std::vector<uint64_t>(1'000, 0), 4, 100, 1);
  const std::vector<uint32_t> items = ItemsOf(table, 0);
  EXPECT_EQ(items.size(), 100u);
  EXPECT_TRUE(std::is_sorted(items.begin(), items.end()));
  EXPECT_EQ(std::adjacent_find(items.begin(), items.end()), items.end());
  // Random: neither the first nor the last hundred, but spread over the thousand.
  EXPECT_LT(items.front(), 100u);
  EXPECT_GT(items.back(), 900u);
  EXPECT_THAT(ItemsOf(table, 1), ::testing::IsEmpty());
}

TEST(BucketTable, ABucketJustFullIsKeptWhole) {
  const BucketTable table = MakeTable(std::vector<uint64_t>(100, ~uint64_t{0}), 4, 100, 1);
  EXPECT_EQ(ItemsOf(table, 15).size(), 100u);
}

TEST(BucketTable, SubsetDependsOnTheSeedAlone) {
  const std::vector<uint64_t> hashes(1'000, 0);
  const BucketTable a = MakeTable(hashes, 4, 100, 1);
  const BucketTable b = MakeTable(hashes, 4, 100, 2);
  const BucketTable again = MakeTable(hashes, 4, 100, 1);
  EXPECT_EQ(ItemsOf(a, 0), ItemsOf(again, 0));
  EXPECT_NE(ItemsOf(a, 0), ItemsOf(b, 0));
}

TEST(BucketTable, ScratchOfOneTableServesTheNext) {
  BucketTable::Scratch scratch;
  for (const size_t count : {1'000, 10, 500}) {
    const std::vector<uint64_t> hashes = RandomHashes(count, count);
    const std::vector<uint32_t> sketches(count, 0);
    const BucketTable table(hashes, sketches, 3, kNoCap, 1, &scratch);
    size_t num_items = 0;
    for (uint32_t bucket = 0; bucket < 8; ++bucket) {
      num_items += table[bucket].items.size();
    }
    EXPECT_EQ(num_items, count);
  }
}

TEST(BucketTable, OfNothingIsEmpty) {
  const BucketTable table = MakeTable({}, 1, 100, 1);
  EXPECT_THAT(ItemsOf(table, 0), ::testing::IsEmpty());
  EXPECT_THAT(ItemsOf(table, 1), ::testing::IsEmpty());
}

}  // namespace
}  // namespace cairn
