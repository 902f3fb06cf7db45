#include "storage/tile_lists.h"

#include <algorithm>
#include <cstring>

namespace cairn {

LargeVector<uint8_t> OrderCodes(std::span<const uint8_t> codes, size_t code_size,
                                const TileLists& lists) {
  LargeVector<uint8_t> ordered(codes.size());
  if (lists.empty()) {
    std::copy(codes.begin(), codes.end(), ordered.begin());
  }
  for (size_t row = 0; row < lists.members.size(); ++row) {
    std::memcpy(ordered.data() + row * code_size, codes.data() + lists.members[row] * code_size,
                code_size);
  }
  return ordered;
}

}  // namespace cairn
