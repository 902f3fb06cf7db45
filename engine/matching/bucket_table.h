// One random grid's content: items sorted by bucket, in compressed rows.
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

  // Item i goes to bucket `hashes[i] >> (64 - num_bucket_bits)`. Of a bucket with more than
  // `max_items` a subset is kept that is random by seed. num_bucket_bits is in [1, 26]. Linear
  // time.
  BucketTable(std::span<const uint64_t> hashes, int num_bucket_bits, int max_items, uint64_t seed,
              Scratch* scratch);

  uint32_t BucketOf(uint64_t hash) const { return static_cast<uint32_t>(hash >> shift_); }

  // Items of a bucket, ascending, at most max_items.
  std::span<const uint32_t> Items(uint32_t bucket) const {
    return {items_.data() + begin_[bucket], begin_[bucket + 1] - begin_[bucket]};
  }

  // Asks the processor to fetch the bounds of a bucket, ahead of Items.
  void Prefetch(uint32_t bucket) const { __builtin_prefetch(&begin_[bucket]); }

  size_t MemoryBytes() const;

 private:
  int shift_;
  std::vector<uint32_t> begin_;  // 2^num_bucket_bits + 1 offsets into items_.
  std::vector<uint32_t> items_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_MATCHING_BUCKET_TABLE_H_
