// Sorts the items of one random grid into buckets by the hashes of their cells.
#ifndef CAIRN_ENGINE_INDEX_HASH_BUCKETS_H_
#define CAIRN_ENGINE_INDEX_HASH_BUCKETS_H_

#include <cstdint>
#include <span>

#include "storage/tile/tile_lists.h"

namespace cairn {

inline constexpr int kNumHashBits = 32;

// Returns the bucket of a hash, which is its upper bits. num_bucket_bits is in [1, 26].
inline uint32_t BucketOf(uint32_t hash, int num_bucket_bits) {
  return hash >> (kNumHashBits - num_bucket_bits);
}

// Returns a list for each of the 2^num_bucket_bits buckets. A list holds the items i whose
// hashes[i] fall into the bucket, ascending. If a bucket has more than `max_items` items, a random
// subset of that size (by seed) comes first and the other items follow. Takes linear time.
TileLists SortIntoBuckets(std::span<const uint32_t> hashes, int num_bucket_bits, int max_items,
                          uint64_t seed);

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_HASH_BUCKETS_H_
