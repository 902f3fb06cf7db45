#include "engine/tiles/tile_content.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/error.h"

namespace cairn {
TileContent::Parts::Parts(Tile tile_in, std::span<const uint32_t> order)
    : tile(std::move(tile_in)), places(tile, order) {}

TileContent::TileContent(Tile tile, std::span<const uint32_t> order)
    : parts_(std::make_unique<const Parts>(std::move(tile), order)) {
  num_bytes_ = parts_->tile.MemoryBytes() + parts_->places.MemoryBytes();
  decoded_ = parts_.get();
}

TileContent::TileContent(TilePayload payload, const TileLists* lists)
    : num_bytes_(std::max(
          payload.num_bytes(),
          payload.TileBytes() + payload.num_descriptors() * DescriptorPlaces::kBytesPerDescriptor)),
      payload_(std::move(payload)),
      lists_(lists) {}

const TileContent::Parts& TileContent::Decode() const {
  const std::lock_guard lock(mutex_);
  if (parts_ == nullptr) {
    try {
      parts_ = std::make_unique<const Parts>(payload_->Decode(*lists_), lists_->members);
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
