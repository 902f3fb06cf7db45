// Which keyframes of a tile saw a landmark, found by its id.
#ifndef CAIRN_ENGINE_TILES_LANDMARK_SIGHTINGS_H_
#define CAIRN_ENGINE_TILES_LANDMARK_SIGHTINGS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/large_vector.h"
#include "storage/ids.h"
#include "storage/tile/tile_views.h"

namespace cairn {

// The other way round than TileCovisibility. A landmark that stands in several tiles has the same
// id in each, so whoever knows it from one tile finds who saw it in another. Open addressing, at
// most half of the slots in use; hashes have a seed of the process, so that no map can be made
// whose ids collide. Immutable; safe to use from any thread.
class LandmarkSightings {
 public:
  // Linear in landmarks and observations. The landmarks must outlive this. Of several with the same
  // id, which no sound tile has, only the first is found.
  LandmarkSightings(const TileLandmarks& landmarks, const TileCovisibility& covisibility);

  // The keyframes of the tile that saw the landmark, ascending; none if the tile does not hold it.
  std::span<const uint32_t> KeyframesThatSaw(LandmarkId id) const;

  // Heap bytes for a tile of that size.
  static size_t MemoryBytes(size_t num_landmarks, size_t num_observations);

 private:
  // The slot of a landmark, or the empty one where it belongs.
  size_t SlotOf(LandmarkId id) const;

  std::span<const LandmarkId> ids_;
  LargeVector<uint32_t> slots_;  // A power of two; one more than the landmark's index, 0 is empty.
  int shift_;
  // Keyframes of landmark i are [begin_[i], begin_[i + 1]) of keyframes_.
  LargeVector<uint32_t> begin_;
  LargeVector<uint32_t> keyframes_;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_TILES_LANDMARK_SIGHTINGS_H_
