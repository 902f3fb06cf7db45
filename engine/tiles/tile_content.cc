#include "engine/tiles/tile_content.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/error.h"

namespace cairn {

TileContent::Matched::Matched(LoadedLandmarks loaded_in, std::span<const uint32_t> order)
    : loaded(std::move(loaded_in)), places(loaded.view, order) {}

TileContent::TileContent(std::shared_ptr<const Tile> tile, std::span<const uint32_t> order)
    : order_(order),
      tile_(std::move(tile)),
      matched_(std::make_unique<const Matched>(LoadedLandmarks{{}, *tile_}, order)),
      rest_(new Rest{{}, *tile_, tile_->codes}) {
  num_bytes_ =
      tile_->MemoryBytes() + matched_->places.MemoryBytes() +
      LandmarkKeyframes::MemoryBytes(tile_->num_landmarks(), tile_->keyframe_landmarks.size());
  ready_matched_ = matched_.get();
  ready_rest_ = rest_.get();
}

TileContent::TileContent(TilePayload payload, std::span<const uint32_t> order,
                         LargeVector<uint8_t> codes)
    : order_(order),
      codes_(std::move(codes)),
      num_bytes_(
          payload.LandmarkBytes() +
          payload.num_descriptors() * DescriptorPlaces::kBytesPerDescriptor +
          LandmarkKeyframes::MemoryBytes(payload.num_landmarks(), payload.num_observations()) +
          codes_.size() +
          std::max(payload.num_bytes(),
                   payload.CovisibilityBytes() + payload.codes().size() - codes_.size())),
      payload_(std::move(payload)) {}

template <typename Part, typename Make>
const Part& TileContent::Complete(std::unique_ptr<const Part>* part,
                                  std::atomic<const Part*>* ready, const Make& make) const {
  const std::lock_guard lock(mutex_);
  if (*part == nullptr) {
    try {
      *part = make();
    } catch (const Error& error) {
      throw Error(error.code(), fmt::format("tile {}: {}; run `cairn check` to find all damage",
                                            payload_->id().ToString(), error.what()));
    }
    ready->store(part->get(), std::memory_order_release);
    if (matched_ != nullptr && rest_ != nullptr) {
      payload_.reset();
    }
  }
  return **part;
}

const TileContent::Matched& TileContent::DecodeMatched() const {
  return Complete(&matched_, &ready_matched_, [this] {
    return std::make_unique<const Matched>(payload_->Landmarks(), order_);
  });
}

const TileContent::Rest& TileContent::DecodeRest() const {
  return Complete(&rest_, &ready_rest_, [this] {
    auto rest = std::make_unique<Rest>();
    rest->loaded = payload_->Covisibility();
    if (codes_.empty()) {
      codes_ = payload_->CodesInTileOrder(payload_->Lists().members);
    }
    rest->view.keyframes = rest->loaded.keyframes;
    rest->view.keyframe_begin = rest->loaded.keyframe_begin;
    rest->view.keyframe_landmarks = rest->loaded.keyframe_landmarks;
    rest->codes = codes_;
    return std::unique_ptr<const Rest>(std::move(rest));
  });
}

const LandmarkKeyframes& TileContent::MakeLandmarkKeyframes() const {
  const TileLandmarks& of_landmarks = landmarks();
  const TileCovisibility& of_keyframes = covisibility();
  return Complete(&landmark_keyframes_, &ready_landmark_keyframes_, [&] {
    return std::make_unique<const LandmarkKeyframes>(of_landmarks, of_keyframes);
  });
}

}  // namespace cairn
