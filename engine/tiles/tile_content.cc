#include "engine/tiles/tile_content.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/error.h"

namespace cairn {
namespace {

LargeVector<uint32_t> LandmarkOfDescriptor(const Tile& tile) {
  // Most landmarks have a few descriptors: writing that many numbers and going back is faster than
  // to count.
  constexpr size_t kAhead = 4;
  LargeVector<uint32_t> landmark_of_descriptor(tile.num_descriptors() + kAhead);
  for (uint32_t landmark = 0; landmark < tile.num_landmarks(); ++landmark) {
    const uint32_t begin = tile.descriptor_begin[landmark];
    const size_t count = tile.descriptor_begin[landmark + 1] - begin;
    std::fill_n(landmark_of_descriptor.begin() + begin, kAhead, landmark);
    if (count > kAhead) {
      std::fill_n(landmark_of_descriptor.begin() + begin, count, landmark);
    }
  }
  landmark_of_descriptor.resize(tile.num_descriptors());
  return landmark_of_descriptor;
}

}  // namespace

TileContent::Parts::Parts(Tile tile_in)
    : tile(std::move(tile_in)), landmark_of_descriptor(LandmarkOfDescriptor(tile)) {}

TileContent::TileContent(Tile tile) : parts_(std::make_unique<const Parts>(std::move(tile))) {
  num_bytes_ =
      parts_->tile.MemoryBytes() + parts_->landmark_of_descriptor.capacity() * sizeof(uint32_t);
  decoded_ = parts_.get();
}

TileContent::TileContent(TilePayload payload, const TileLists* lists)
    : num_bytes_(std::max(payload.num_bytes(),
                          payload.TileBytes() + payload.num_descriptors() * sizeof(uint32_t))),
      payload_(std::move(payload)),
      lists_(lists) {}

const TileContent::Parts& TileContent::Decode() const {
  const std::lock_guard lock(mutex_);
  if (parts_ == nullptr) {
    try {
      parts_ = std::make_unique<const Parts>(payload_->Decode(*lists_));
    } catch (const Error& error) {
      throw Error(error.code(), fmt::format("tile {}: {}; `cairn check` looks for more",
                                            payload_->id().ToString(), error.what()));
    }
    payload_.reset();
    decoded_.store(parts_.get(), std::memory_order_release);
  }
  return *parts_;
}

}  // namespace cairn
