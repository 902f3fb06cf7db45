// A set of landmarks, found again in any tile.
#ifndef CAIRN_ENGINE_REFINEMENT_LANDMARK_TABLE_H_
#define CAIRN_ENGINE_REFINEMENT_LANDMARK_TABLE_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "storage/ids.h"
#include "storage/tile_views.h"

namespace cairn {

// A set of a tile's landmarks, a bit each.
class LandmarkMarks {
 public:
  explicit LandmarkMarks(size_t num_landmarks) : words_((num_landmarks + 63) / 64, 0) {}

  void Set(uint32_t landmark_idx) { words_[landmark_idx / 64] |= uint64_t{1} << landmark_idx % 64; }
  bool Has(uint32_t landmark_idx) const {
    return (words_[landmark_idx / 64] >> landmark_idx % 64 & 1) != 0;
  }

 private:
  std::vector<uint64_t> words_;
};

// Numbers distinct landmark ids 0, 1, ... in order of insertion. A landmark that stands in several
// tiles has the same id in each, so a table made from one tile serves them all. Open addressing
// behind a bit filter small enough for the nearest cache; a look-up that misses, the usual case,
// hardly ever gets past the filter. Const calls are thread-safe.
class LandmarkTable {
 public:
  // For at most `max_size` landmarks.
  explicit LandmarkTable(size_t max_size);

  // The number of a landmark, inserted if it is new. `id` is not 0.
  int Insert(LandmarkId id);

  // The number of a landmark, or -1.
  int Find(LandmarkId id) const;

  int size() const { return size_; }

  // The landmarks of a tile that are in the table, by index into the tile.
  LandmarkMarks Mark(const TileLandmarks& tile) const;

 private:
  struct Slot {
    LandmarkId id{};  // 0 is empty.
    int32_t number = -1;
  };
  // The slot of a landmark, or the empty one where it belongs.
  size_t SlotOf(LandmarkId id) const;
  bool MayHold(LandmarkId id) const;

  int shift_;
  int filter_shift_;
  std::vector<Slot> slots_;       // A power of two, at least half of them empty.
  std::vector<uint64_t> filter_;  // A power of two, at least 16 bits a landmark.
  int size_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_REFINEMENT_LANDMARK_TABLE_H_
