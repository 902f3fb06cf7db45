// The content of a tile apart from its index, decoded on demand.
#ifndef CAIRN_ENGINE_TILES_TILE_CONTENT_H_
#define CAIRN_ENGINE_TILES_TILE_CONTENT_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>

#include "core/large_vector.h"
#include "engine/tiles/descriptor_places.h"
#include "engine/tiles/landmark_keyframes.h"
#include "storage/tile/tile.h"
#include "storage/tile/tile_payload.h"
#include "storage/tile/tile_views.h"

namespace cairn {

// Matching needs landmarks and places; covisibility and codes are for queries that matching leaves
// in doubt. Each of these two halves is decoded once, by the first thread that requests it, while
// other threads wait. The lists of keyframes are built from both halves in the same way. Safe to
// use from any thread.
class TileContent {
 public:
  // `order` is the index's (MatchingIndex::order) and must outlive the object. The codes keep their
  // address.
  TileContent(std::shared_ptr<const Tile> tile, std::span<const uint32_t> order);
  // `codes` are in tile order and keep their address. If `codes` is empty, they are decoded with
  // the rest.
  TileContent(TilePayload payload, std::span<const uint32_t> order,
              LargeVector<uint8_t> codes = {});

  // The accessors throw Error(kMapDamaged), on every call, if the payload does not decode.
  const TileLandmarks& landmarks() const { return matched().loaded.view; }
  const DescriptorPlaces& places() const { return matched().places; }
  const TileCovisibility& covisibility() const { return rest().view; }
  // num_descriptors x code_size, in tile order.
  std::span<const uint8_t> codes() const { return rest().codes; }
  const LandmarkKeyframes& landmark_keyframes() const {
    const LandmarkKeyframes* landmark_keyframes =
        ready_landmark_keyframes_.load(std::memory_order_acquire);
    return landmark_keyframes != nullptr ? *landmark_keyframes : MakeLandmarkKeyframes();
  }

  // Upper bound on the heap bytes, decoded or not.
  size_t MemoryBytes() const { return num_bytes_; }

 private:
  struct Matched {
    Matched(LoadedLandmarks loaded_in, std::span<const uint32_t> order);

    LoadedLandmarks loaded;
    DescriptorPlaces places;
  };
  // `loaded` is empty if the views point into tile_.
  struct Rest {
    LoadedCovisibility loaded;
    TileCovisibility view;
    std::span<const uint8_t> codes;
  };

  const Matched& matched() const {
    const Matched* matched = ready_matched_.load(std::memory_order_acquire);
    return matched != nullptr ? *matched : DecodeMatched();
  }
  const Rest& rest() const {
    const Rest* rest = ready_rest_.load(std::memory_order_acquire);
    return rest != nullptr ? *rest : DecodeRest();
  }
  const Matched& DecodeMatched() const;
  const Rest& DecodeRest() const;
  const LandmarkKeyframes& MakeLandmarkKeyframes() const;
  // Sets a part to the result of make(), unless another thread has set it.
  template <typename Part, typename Make>
  const Part& Complete(std::unique_ptr<const Part>* part, std::atomic<const Part*>* ready,
                       const Make& make) const;

  std::span<const uint32_t> order_;
  std::shared_ptr<const Tile> tile_;    // Set if the tile was decoded at construction.
  mutable LargeVector<uint8_t> codes_;  // Codes of a payload; not changed once set.
  size_t num_bytes_;
  mutable std::mutex mutex_;                    // Guards the next four members.
  mutable std::optional<TilePayload> payload_;  // Set until all of it is decoded.
  mutable std::unique_ptr<const Matched> matched_;
  mutable std::unique_ptr<const Rest> rest_;
  mutable std::unique_ptr<const LandmarkKeyframes> landmark_keyframes_;
  // Published once the parts above are built, for reading without the lock.
  mutable std::atomic<const Matched*> ready_matched_ = nullptr;
  mutable std::atomic<const Rest*> ready_rest_ = nullptr;
  mutable std::atomic<const LandmarkKeyframes*> ready_landmark_keyframes_ = nullptr;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_TILE_CONTENT_H_
