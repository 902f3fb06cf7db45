#include "engine/matching/hash_buckets.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/check.h"
#include "engine/matching/random_bits.h"

namespace cairn {
namespace {

constexpr int kItemBits = 32;
constexpr uint64_t kItemMask = (uint64_t{1} << kItemBits) - 1;

// One stable counting pass over `num_bits` bits of the key from `low_bit` on.
void CountingPass(const std::vector<uint64_t>& from, int low_bit, int num_bits,
                  std::vector<uint64_t>* to) {
  const uint64_t mask = (uint64_t{1} << num_bits) - 1;
  std::vector<uint32_t> position(mask + 1, 0);
  for (const uint64_t pair : from) {
    ++position[(pair >> low_bit) & mask];
  }
  uint32_t sum = 0;
  for (uint32_t& count : position) {
    sum += std::exchange(count, sum);
  }
  to->resize(from.size());
  for (const uint64_t pair : from) {
    (*to)[position[(pair >> low_bit) & mask]++] = pair;
  }
}

// Sorts scratch->pairs by bucket with two passes, each small enough for the cache.
void SortByBucket(int num_bucket_bits, BucketScratch* scratch) {
  const int num_low_bits = num_bucket_bits / 2;
  CountingPass(scratch->pairs, kItemBits, num_low_bits, &scratch->sorted_pairs);
  CountingPass(scratch->sorted_pairs, kItemBits + num_low_bits, num_bucket_bits - num_low_bits,
               &scratch->pairs);
}

uint32_t BucketOfPair(uint64_t pair) { return static_cast<uint32_t>(pair >> kItemBits); }
uint32_t ItemOfPair(uint64_t pair) { return static_cast<uint32_t>(pair & kItemMask); }

// Puts a subset of `max_items` items, random by seed, in front of the others; both ascending.
void PutSubsetFirst(size_t max_items, uint64_t seed, std::span<uint32_t> items) {
  const auto middle = items.begin() + static_cast<ptrdiff_t>(max_items);
  std::nth_element(items.begin(), middle, items.end(), [seed](uint32_t a, uint32_t b) {
    return RandomBits(seed, a) < RandomBits(seed, b);
  });
  std::sort(items.begin(), middle);
  std::sort(middle, items.end());
}

// For each bucket the number of pairs before it, and that of all.
std::vector<uint32_t> FirstOfBuckets(const std::vector<uint64_t>& pairs, uint32_t num_buckets) {
  std::vector<uint32_t> begin(num_buckets + 1, 0);
  for (const uint64_t pair : pairs) {
    ++begin[BucketOfPair(pair) + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  return begin;
}

}  // namespace

TileLists SortIntoBuckets(std::span<const uint32_t> hashes, int num_bucket_bits, int max_items,
                          uint64_t seed, BucketScratch* scratch) {
  CAIRN_CHECK(hashes.size() < kItemMask, "items must fit 32 bits");
  std::vector<uint64_t>& pairs = scratch->pairs;
  pairs.resize(hashes.size());
  for (size_t i = 0; i < hashes.size(); ++i) {
    pairs[i] = uint64_t{BucketOf(hashes[i], num_bucket_bits)} << kItemBits | i;
  }
  SortByBucket(num_bucket_bits, scratch);
  TileLists lists;
  lists.begin = FirstOfBuckets(pairs, uint32_t{1} << num_bucket_bits);
  lists.members.resize(pairs.size());
  std::transform(pairs.begin(), pairs.end(), lists.members.begin(), ItemOfPair);
  for (size_t bucket = 0; bucket < lists.num_lists(); ++bucket) {
    const size_t size = lists.begin[bucket + 1] - lists.begin[bucket];
    if (size > static_cast<size_t>(max_items)) {
      PutSubsetFirst(max_items, seed, {lists.members.data() + lists.begin[bucket], size});
    }
  }
  return lists;
}

}  // namespace cairn
