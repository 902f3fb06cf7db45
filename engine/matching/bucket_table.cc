#include "engine/matching/bucket_table.h"

#include <algorithm>
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

// Cuts the items from `begin` to the end down to a random `max_items` of them, still ascending.
void KeepRandomSubset(size_t begin, int max_items, uint64_t seed, std::vector<uint32_t>* items) {
  const auto first = items->begin() + static_cast<ptrdiff_t>(begin);
  std::nth_element(first, first + max_items, items->end(), [seed](uint32_t a, uint32_t b) {
    return RandomBits(seed, a) < RandomBits(seed, b);
  });
  items->resize(begin + max_items);
  std::sort(items->begin() + static_cast<ptrdiff_t>(begin), items->end());
}

}  // namespace

BucketTable::BucketTable(std::span<const uint64_t> hashes, int num_bucket_bits, int max_items,
                         uint64_t seed, Scratch* scratch)
    : shift_(64 - num_bucket_bits) {
  CAIRN_CHECK(hashes.size() < kItemMask, "items must fit 32 bits");
  scratch->pairs.resize(hashes.size());
  for (size_t i = 0; i < hashes.size(); ++i) {
    scratch->pairs[i] = uint64_t{BucketOf(hashes[i])} << kItemBits | i;
  }
  SortByBucket(num_bucket_bits, scratch);

  const uint32_t num_buckets = uint32_t{1} << num_bucket_bits;
  begin_.reserve(num_buckets + 1);
  begin_.push_back(0);
  items_.reserve(hashes.size());
  auto pair = scratch->pairs.begin();
  for (uint32_t bucket = 0; bucket < num_buckets; ++bucket) {
    for (; pair != scratch->pairs.end() && *pair >> kItemBits == bucket; ++pair) {
      items_.push_back(static_cast<uint32_t>(*pair & kItemMask));
    }
    if (items_.size() - begin_.back() > static_cast<size_t>(max_items)) {
      KeepRandomSubset(begin_.back(), max_items, seed, &items_);
    }
    begin_.push_back(static_cast<uint32_t>(items_.size()));
  }
}

size_t BucketTable::MemoryBytes() const {
  return (begin_.capacity() + items_.capacity()) * sizeof(uint32_t);
}

}  // namespace cairn
