#include "engine/refinement/landmark_table.h"

#include <bit>

namespace cairn {
namespace {

// Fibonacci hashing: ids are often consecutive. The upper bits are the good ones.
uint64_t Hash(LandmarkId id) { return Value(id) * 0x9e3779b97f4a7c15u; }

}  // namespace

LandmarkTable::LandmarkTable(size_t max_size) {
  const size_t num_slots = std::bit_ceil(2 * max_size + 2);
  slots_.resize(num_slots);
  shift_ = 64 - std::countr_zero(num_slots);
  const size_t num_filter_bits = std::bit_ceil(16 * max_size + 64);
  filter_.resize(num_filter_bits / 64);
  filter_shift_ = 64 - std::countr_zero(num_filter_bits);
}

size_t LandmarkTable::SlotOf(LandmarkId id) const {
  size_t slot = Hash(id) >> shift_;
  while (slots_[slot].id != LandmarkId{} && slots_[slot].id != id) {
    slot = (slot + 1) & (slots_.size() - 1);
  }
  return slot;
}

bool LandmarkTable::MayHold(LandmarkId id) const {
  const uint64_t bit = Hash(id) >> filter_shift_;
  return (filter_[bit / 64] >> bit % 64 & 1) != 0;
}

int LandmarkTable::Insert(LandmarkId id) {
  Slot& slot = slots_[SlotOf(id)];
  if (slot.id == LandmarkId{}) {
    slot = {id, size_++};
    const uint64_t bit = Hash(id) >> filter_shift_;
    filter_[bit / 64] |= uint64_t{1} << bit % 64;
  }
  return slot.number;
}

int LandmarkTable::Find(LandmarkId id) const {
  return MayHold(id) ? slots_[SlotOf(id)].number : -1;
}

LandmarkMarks LandmarkTable::Mark(const TileLandmarks& tile) const {
  LandmarkMarks marks(tile.num_landmarks());
  for (size_t i = 0; i < tile.num_landmarks(); ++i) {
    if (Find(tile.landmark_ids[i]) >= 0) {
      marks.Set(static_cast<uint32_t>(i));
    }
  }
  return marks;
}

}  // namespace cairn
