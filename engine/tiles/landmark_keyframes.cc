#include "engine/tiles/landmark_keyframes.h"

#include <bit>
#include <numeric>
#include <random>

#include "core/random.h"

namespace cairn {
namespace {

size_t NumSlots(size_t num_landmarks) { return std::bit_ceil(2 * num_landmarks + 2); }

uint64_t Hash(LandmarkId id) {
  static const uint64_t seed = std::random_device()();
  return RandomBits(seed, Value(id));
}

}  // namespace

LandmarkKeyframes::LandmarkKeyframes(const TileLandmarks& landmarks,
                                     const TileCovisibility& covisibility)
    : ids_(landmarks.landmark_ids),
      slots_(NumSlots(ids_.size()), 0),
      shift_(64 - std::countr_zero(slots_.size())),
      begin_(ids_.size() + 2, 0),
      keyframes_(covisibility.keyframe_landmarks.size()) {
  for (size_t i = 0; i < ids_.size(); ++i) {
    uint32_t& slot = slots_[SlotOf(ids_[i])];
    slot = slot == 0 ? static_cast<uint32_t>(i) + 1 : slot;
  }
  // A counting sort. While it runs, begin_[i + 1] is the next position of landmark i; at the end,
  // it is the end of landmark i.
  for (const uint32_t landmark_idx : covisibility.keyframe_landmarks) {
    ++begin_[landmark_idx + 2];
  }
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  for (size_t k = 0; k < covisibility.num_keyframes(); ++k) {
    for (const uint32_t landmark_idx : covisibility.LandmarksOfKeyframe(k)) {
      keyframes_[begin_[landmark_idx + 1]++] = static_cast<uint32_t>(k);
    }
  }
}

size_t LandmarkKeyframes::SlotOf(LandmarkId id) const {
  size_t slot = Hash(id) >> shift_;
  while (slots_[slot] != 0 && ids_[slots_[slot] - 1] != id) {
    slot = (slot + 1) & (slots_.size() - 1);
  }
  return slot;
}

std::span<const uint32_t> LandmarkKeyframes::KeyframesThatSaw(LandmarkId id) const {
  const uint32_t slot = slots_[SlotOf(id)];
  if (slot == 0) {
    return {};
  }
  const uint32_t landmark_idx = slot - 1;
  return std::span(keyframes_)
      .subspan(begin_[landmark_idx], begin_[landmark_idx + 1] - begin_[landmark_idx]);
}

size_t LandmarkKeyframes::MemoryBytes(size_t num_landmarks, size_t num_observations) {
  return (NumSlots(num_landmarks) + num_landmarks + 2 + num_observations) * sizeof(uint32_t);
}

}  // namespace cairn
