// Items sorted by the hash of their cell: the content of one random grid.
#ifndef CAIRN_ENGINE_INDEX_HASH_BUCKETS_H_
#define CAIRN_ENGINE_INDEX_HASH_BUCKETS_H_

#include <cstdint>
#include <span>

#include "storage/tile/tile_lists.h"

namespace cairn {

// The bucket of a hash: its upper bits. num_bucket_bits is in [1, 26].
inline uint32_t BucketOf(uint32_t hash, int num_bucket_bits) {
  return hash >> (32 - num_bucket_bits);
}

// A list a bucket, 2^num_bucket_bits of them, that holds the items i of hashes[i], ascending. Of a
// bucket with more than `max_items` the first so many are a subset that is random by seed; the rest
// follows it. Linear time.
TileLists SortIntoBuckets(std::span<const uint32_t> hashes, int num_bucket_bits, int max_items,
                          uint64_t seed);

}  // namespace cairn

#endif  // CAIRN_ENGINE_INDEX_HASH_BUCKETS_H_
