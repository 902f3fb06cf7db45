// Finds the keyframes of a tile that saw a landmark, by the landmark's id.
#ifndef CAIRN_ENGINE_TILES_LANDMARK_KEYFRAMES_H_
#define CAIRN_ENGINE_TILES_LANDMARK_KEYFRAMES_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/large_vector.h"
#include "storage/ids.h"
#include "storage/tile/tile_views.h"

namespace cairn {

// The inverse of TileCovisibility. A landmark has the same id in every tile, so a landmark known
// from one tile can be looked up in another. The hash table uses open addressing with at most half
// of the slots filled. Each process has its own random hash seed, so nobody can make a map whose
// ids collide. Immutable; safe to use from any thread.
class LandmarkKeyframes {
 public:
  // Linear in landmarks and observations. The landmarks must outlive the object. If several
  // landmarks have the same id, as only a damaged tile has, only the first can be found.
  LandmarkKeyframes(const TileLandmarks& landmarks, const TileCovisibility& covisibility);

  // Returns the keyframes of the tile that saw the landmark, ascending; empty if the tile does not
  // hold the landmark.
  std::span<const uint32_t> KeyframesThatSaw(LandmarkId id) const;

  // Returns the heap bytes for a tile of this size.
  static size_t MemoryBytes(size_t num_landmarks, size_t num_observations);

 private:
  // Returns the slot of a landmark, or the empty slot for it.
  size_t SlotOf(LandmarkId id) const;

  std::span<const LandmarkId> ids_;
  // The size is a power of two. A slot holds a landmark's index plus 1; 0 is empty.
  LargeVector<uint32_t> slots_;
  int shift_;
  // The keyframes of landmark i are keyframes_[begin_[i]] to keyframes_[begin_[i + 1] - 1].
  LargeVector<uint32_t> begin_;
  LargeVector<uint32_t> keyframes_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_LANDMARK_KEYFRAMES_H_
