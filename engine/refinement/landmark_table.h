// A set of landmarks, found again in any tile.
#ifndef CAIRN_ENGINE_REFINEMENT_LANDMARK_TABLE_H_
#define CAIRN_ENGINE_REFINEMENT_LANDMARK_TABLE_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "storage/ids.h"
#include "storage/tile.h"

namespace cairn {

// Numbers distinct landmark ids 0, 1, ... in order of insertion. A landmark that stands in several
// tiles has the same id in each, so a table made from one tile serves them all. Open addressing; a
// look-up that misses, the usual case, costs one memory access. Const calls are thread-safe.
class LandmarkTable {
 public:
  // For at most `max_size` landmarks.
  explicit LandmarkTable(size_t max_size);

  // The number of a landmark, inserted if it is new. `id` is not 0.
  int Insert(LandmarkId id);

  // The number of a landmark, or -1.
  int Find(LandmarkId id) const;

  int size() const { return size_; }

  // Find for every landmark of a tile.
  std::vector<int32_t> FindAll(const Tile& tile) const;

 private:
  struct Slot {
    LandmarkId id{};  // 0 is empty.
    int32_t number = -1;
  };
  // The slot of a landmark, or the empty one where it belongs.
  size_t SlotOf(LandmarkId id) const;

  int shift_;
  std::vector<Slot> slots_;  // A power of two, at least half of them empty.
  int size_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_REFINEMENT_LANDMARK_TABLE_H_
