// Lists that group the descriptors of a tile for search, stored so that loading need not compute
// them.
#ifndef CAIRN_STORAGE_TILE_TILE_LISTS_H_
#define CAIRN_STORAGE_TILE_TILE_LISTS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/large_vector.h"

namespace cairn {

// Lists of similar descriptors; each descriptor is in one list. A plain value. `begin` is empty if
// there are no lists.
struct TileLists {
  std::vector<uint32_t> begin;    // num_lists + 1 offsets into `members`.
  LargeVector<uint32_t> members;  // Descriptor indices, ascending within a list.

  bool empty() const { return begin.empty(); }
  size_t num_lists() const { return begin.empty() ? 0 : begin.size() - 1; }
  std::span<const uint32_t> Members(size_t list) const {
    return {members.data() + begin[list], begin[list + 1] - begin[list]};
  }

  friend bool operator==(const TileLists&, const TileLists&) = default;
};

// Copies rows of `row_size` bytes to `to`, in the order of `members`.
void GatherRows(std::span<const uint8_t> rows, size_t row_size, std::span<const uint32_t> members,
                uint8_t* to);

// Returns the rows of `code_size` bytes in list order; in the given order if there are no lists.
LargeVector<uint8_t> OrderCodes(std::span<const uint8_t> codes, size_t code_size,
                                const TileLists& lists);

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_TILE_LISTS_H_
