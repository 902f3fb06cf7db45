// What a tile holds beside its index, decoded when it is wanted.
#ifndef CAIRN_ENGINE_TILES_TILE_CONTENT_H_
#define CAIRN_ENGINE_TILES_TILE_CONTENT_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>

#include "engine/tiles/descriptor_places.h"
#include "storage/tile.h"
#include "storage/tile_lists.h"
#include "storage/tile_payload.h"

namespace cairn {

// A tile is decoded once, by the first thread that asks; others wait for it. Safe to use from any
// thread.
class TileContent {
 public:
  // `order` is the index's (MatchingIndex::order), and must outlive this.
  TileContent(Tile tile, std::span<const uint32_t> order);
  // `lists` are the payload's, and must outlive this.
  TileContent(TilePayload payload, const TileLists* lists);

  // Both throw Error(kMapDamaged), every time, if the payload does not decode.
  const Tile& tile() const { return Decoded().tile; }
  const DescriptorPlaces& places() const { return Decoded().places; }

  // Heap bytes, those of the decoded tile also while it is not decoded yet.
  size_t MemoryBytes() const { return num_bytes_; }

 private:
  struct Parts {
    Parts(Tile tile_in, std::span<const uint32_t> order);

    Tile tile;
    DescriptorPlaces places;
  };

  const Parts& Decoded() const {
    const Parts* parts = decoded_.load(std::memory_order_acquire);
    return parts != nullptr ? *parts : Decode();
  }
  const Parts& Decode() const;

  size_t num_bytes_;
  mutable std::mutex mutex_;                    // Of the next two.
  mutable std::optional<TilePayload> payload_;  // Until it is decoded.
  mutable std::unique_ptr<const Parts> parts_;
  mutable std::atomic<const Parts*> decoded_ = nullptr;  // parts_ as soon as there are any.
  const TileLists* lists_ = nullptr;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_TILE_CONTENT_H_
