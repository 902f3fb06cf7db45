// One random grid's content: items and their sketches sorted by bucket, in compressed rows.
#ifndef CAIRN_ENGINE_MATCHING_BUCKET_TABLE_H_
#define CAIRN_ENGINE_MATCHING_BUCKET_TABLE_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cairn {

// Immutable; safe to use from any thread.
class BucketTable {
 public:
  // Working memory of a build, kept from one grid to the next.
  struct Scratch {
    std::vector<uint64_t> pairs, sorted_pairs;  // bucket << 32 | item
  };

  // A bucket's items, ascending, at most max_items, and the sketch of each.
  struct Bucket {
    std::span<const uint32_t> sketches;
    std::span<const uint32_t> items;
  };

  // Item i goes to bucket `hashes[i] >> (64 - num_bucket_bits)` with sketches[i]. Of a bucket with
  // more than `max_items` a subset is kept that is random by seed. num_bucket_bits is in [1, 26].
  // Linear time.
  BucketTable(std::span<const uint64_t> hashes, std::span<const uint32_t> sketches,
              int num_bucket_bits, int max_items, uint64_t seed, Scratch* scratch);

  uint32_t BucketOf(uint64_t hash) const { return static_cast<uint32_t>(hash >> shift_); }

  Bucket operator[](uint32_t bucket) const {
    const size_t size = begin_[bucket + 1] - begin_[bucket];
    const uint32_t* sketches = content_.data() + 2 * size_t{begin_[bucket]};
    return {{sketches, size}, {sketches + size, size}};
  }

  // Asks the processor to fetch the bounds of a bucket, ahead of reading it.
  void Prefetch(uint32_t bucket) const { __builtin_prefetch(&begin_[bucket]); }

  size_t MemoryBytes() const;

 private:
  int shift_;
  std::vector<uint32_t> begin_;  // 2^num_bucket_bits + 1; a bucket's number of items before it.
  // Bucket after bucket, of each first the sketches, then the items: what is read together lies
  // together.
  std::vector<uint32_t> content_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_MATCHING_BUCKET_TABLE_H_
