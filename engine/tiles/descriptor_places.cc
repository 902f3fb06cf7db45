#include "engine/tiles/descriptor_places.h"

#include <algorithm>
#include <utility>

namespace cairn {
namespace {

// The packed attributes of a descriptor in the lower half, its landmark in the upper half.
using Entry = uint64_t;

// Returns the entries of all descriptors of a tile, in the tile's order.
LargeVector<Entry> MakeEntries(const TileLandmarks& tile, const CoarseGrid& grid) {
  // Most landmarks have few descriptors. Always writing kAhead entries and stepping back is faster
  // than counting.
  constexpr size_t kAhead = 4;
  LargeVector<Entry> entries(tile.num_descriptors() + kAhead);
  for (uint32_t landmark = 0; landmark < tile.num_landmarks(); ++landmark) {
    const uint32_t begin = tile.descriptor_begin[landmark];
    const size_t count = tile.descriptor_begin[landmark + 1] - begin;
    const Entry entry = Entry{landmark} << 32 | grid.PackXy(tile.x_in_tile[landmark]);
    std::fill_n(entries.data() + begin, kAhead, entry);
    if (count > kAhead) {
      std::fill_n(entries.data() + begin, count, entry);
    }
  }
  for (size_t i = 0; i < tile.num_descriptors(); ++i) {
    entries[i] |= tile.orientation_codes[i];
  }
  return entries;
}

}  // namespace

CoarseGrid::CoarseGrid(const TileLandmarks& tile) {
  if (tile.num_landmarks() == 0) {
    return;
  }
  Eigen::Vector3f low = tile.x_in_tile.front(), high = low;
  for (const Eigen::Vector3f& x_in_tile : tile.x_in_tile) {
    low = low.cwiseMin(x_in_tile);
    high = high.cwiseMax(x_in_tile);
  }
  corner_ = low.head<2>();
  max_height_m_ = std::max(-low.z(), high.z());
  step_m_ = std::max((high - low).head<2>().maxCoeff(), 1.0f) / static_cast<float>(kMaxCoordinate);
  steps_per_m_ = 1.0f / step_m_;
}

DescriptorPlaces::DescriptorPlaces(const TileLandmarks& tile, std::span<const uint32_t> order)
    : grid_(tile),
      order_(order),
      packed_(tile.num_descriptors()),
      landmarks_(tile.num_descriptors()) {
  // The entries of adjacent places are scattered over an array larger than a level 2 cache. Both
  // numbers are read with one access, which is prefetched.
  constexpr size_t kAhead = 32;
  const LargeVector<Entry> entries = MakeEntries(tile, grid_);
  for (size_t place = 0; place < packed_.size(); ++place) {
    __builtin_prefetch(&entries[descriptor(std::min(place + kAhead, packed_.size() - 1))]);
    const Entry entry = entries[descriptor(place)];
    packed_[place] = static_cast<uint32_t>(entry);
    landmarks_[place] = static_cast<uint32_t>(entry >> 32);
  }
}

DescriptorPlaces::DescriptorPlaces(const TileLandmarks& tile, const CoarseGrid& grid,
                                   std::span<const uint32_t> descriptors,
                                   LargeVector<uint32_t> landmarks)
    : grid_(grid),
      order_(descriptors),
      packed_(landmarks.size()),
      landmarks_(std::move(landmarks)) {
  for (size_t place = 0; place < packed_.size(); ++place) {
    packed_[place] =
        grid_.PackXy(tile.x_in_tile[landmarks_[place]]) | tile.orientation_codes[descriptor(place)];
  }
}

}  // namespace cairn
