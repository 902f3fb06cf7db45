#include "engine/index/hash_buckets.h"

#include <algorithm>
#include <cstddef>

#include "core/random.h"
#include "engine/index/cell_lists.h"

namespace cairn {
namespace {

// Moves a random subset of `max_items` items to the front. The subset and the remaining items are
// each ascending.
void PutSubsetFirst(size_t max_items, uint64_t seed, std::span<uint32_t> items) {
  const auto middle = items.begin() + static_cast<ptrdiff_t>(max_items);
  std::nth_element(items.begin(), middle, items.end(), [seed](uint32_t a, uint32_t b) {
    return RandomBits(seed, a) < RandomBits(seed, b);
  });
  std::sort(items.begin(), middle);
  std::sort(middle, items.end());
}

}  // namespace

TileLists SortIntoBuckets(std::span<const uint32_t> hashes, int num_bucket_bits, int max_items,
                          uint64_t seed) {
  TileLists lists =
      ListsOfCells(hashes, size_t{1} << num_bucket_bits, kNumHashBits - num_bucket_bits);
  for (size_t bucket = 0; bucket < lists.num_lists(); ++bucket) {
    const size_t size = lists.begin[bucket + 1] - lists.begin[bucket];
    if (size > static_cast<size_t>(max_items)) {
      PutSubsetFirst(max_items, seed, {lists.members.data() + lists.begin[bucket], size});
    }
  }
  return lists;
}

}  // namespace cairn
