#include "engine/matching/bucket_table.h"

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
void SortByBucket(int num_bucket_bits, BucketTable::Scratch* scratch) {
  const int num_low_bits = num_bucket_bits / 2;
  CountingPass(scratch->pairs, kItemBits, num_low_bits, &scratch->sorted_pairs);
  CountingPass(scratch->sorted_pairs, kItemBits + num_low_bits, num_bucket_bits - num_low_bits,
               &scratch->pairs);
}

uint32_t BucketOfPair(uint64_t pair) { return static_cast<uint32_t>(pair >> kItemBits); }
uint32_t ItemOfPair(uint64_t pair) { return static_cast<uint32_t>(pair & kItemMask); }

// Of each bucket of the sorted pairs keeps at most `max_items`, random by seed.
void CapBuckets(size_t max_items, uint64_t seed, std::vector<uint64_t>* pairs) {
  size_t num_kept = 0;
  for (size_t begin = 0, end = 0; begin < pairs->size(); begin = end) {
    const uint32_t bucket = BucketOfPair((*pairs)[begin]);
    while (end < pairs->size() && BucketOfPair((*pairs)[end]) == bucket) {
      ++end;
    }
    const auto first = pairs->begin() + static_cast<ptrdiff_t>(begin);
    auto last = pairs->begin() + static_cast<ptrdiff_t>(end);
    if (end - begin > max_items) {
      std::nth_element(first, first + static_cast<ptrdiff_t>(max_items), last,
                       [seed](uint64_t a, uint64_t b) {
                         return RandomBits(seed, ItemOfPair(a)) < RandomBits(seed, ItemOfPair(b));
                       });
      last = first + static_cast<ptrdiff_t>(max_items);
      std::sort(first, last);
    }
    std::copy(first, last, pairs->begin() + static_cast<ptrdiff_t>(num_kept));
    num_kept += static_cast<size_t>(last - first);
  }
  pairs->resize(num_kept);
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

size_t LargestBucket(const std::vector<uint32_t>& begin) {
  uint32_t largest = 0;
  for (size_t bucket = 0; bucket + 1 < begin.size(); ++bucket) {
    largest = std::max(largest, begin[bucket + 1] - begin[bucket]);
  }
  return largest;
}

}  // namespace

BucketTable::BucketTable(std::span<const uint64_t> hashes, std::span<const uint32_t> sketches,
                         int num_bucket_bits, int max_items, uint64_t seed, Scratch* scratch)
    : shift_(64 - num_bucket_bits) {
  CAIRN_CHECK(hashes.size() < kItemMask, "items must fit 32 bits");
  std::vector<uint64_t>& pairs = scratch->pairs;
  pairs.resize(hashes.size());
  for (size_t i = 0; i < hashes.size(); ++i) {
    pairs[i] = uint64_t{BucketOf(hashes[i])} << kItemBits | i;
  }
  SortByBucket(num_bucket_bits, scratch);
  const uint32_t num_buckets = uint32_t{1} << num_bucket_bits;
  begin_ = FirstOfBuckets(pairs, num_buckets);
  if (LargestBucket(begin_) > static_cast<size_t>(max_items)) {
    CapBuckets(max_items, seed, &pairs);
    begin_ = FirstOfBuckets(pairs, num_buckets);
  }
  // Before a bucket's i-th sketch come twice as many numbers as items of earlier buckets, and i.
  content_.resize(2 * pairs.size());
  for (size_t i = 0; i < pairs.size(); ++i) {
    const uint32_t bucket = BucketOfPair(pairs[i]);
    const uint32_t item = ItemOfPair(pairs[i]);
    content_[begin_[bucket] + i] = sketches[item];
    content_[begin_[bucket + 1] + i] = item;
  }
}

size_t BucketTable::MemoryBytes() const {
  return (begin_.capacity() + content_.capacity()) * sizeof(uint32_t);
}

}  // namespace cairn
