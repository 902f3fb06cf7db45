#include "engine/refinement/landmark_table.h"

#include <bit>

namespace cairn {

LandmarkTable::LandmarkTable(size_t max_size) {
  const size_t num_slots = std::bit_ceil(2 * max_size + 2);
  slots_.resize(num_slots);
  shift_ = 64 - std::countr_zero(num_slots);
}

size_t LandmarkTable::SlotOf(LandmarkId id) const {
  // Fibonacci hashing: ids are often consecutive.
  size_t slot = (Value(id) * 0x9e3779b97f4a7c15u) >> shift_;
  while (slots_[slot].id != LandmarkId{} && slots_[slot].id != id) {
    slot = (slot + 1) & (slots_.size() - 1);
  }
  return slot;
}

int LandmarkTable::Insert(LandmarkId id) {
  Slot& slot = slots_[SlotOf(id)];
  if (slot.id == LandmarkId{}) {
    slot = {id, size_++};
  }
  return slot.number;
}

int LandmarkTable::Find(LandmarkId id) const { return slots_[SlotOf(id)].number; }

std::vector<int32_t> LandmarkTable::FindAll(const Tile& tile) const {
  std::vector<int32_t> numbers;
  numbers.reserve(tile.num_landmarks());
  for (const LandmarkId id : tile.landmark_ids) {
    numbers.push_back(Find(id));
  }
  return numbers;
}

}  // namespace cairn
