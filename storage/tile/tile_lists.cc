#include "storage/tile/tile_lists.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace cairn {
namespace {

// Copies rows of `size` bytes in the order of `members`. The rows are scattered in memory, so they
// are prefetched.
template <typename Size>
void Gather(const uint8_t* rows, Size size, std::span<const uint32_t> members, uint8_t* to) {
  constexpr size_t kAhead = 16;
  const auto copy = [&](size_t i) { std::memcpy(to + i * size, rows + members[i] * size, size); };
  const size_t num_ahead = members.size() - std::min(members.size(), kAhead);
  for (size_t i = 0; i < num_ahead; ++i) {
    __builtin_prefetch(rows + members[i + kAhead] * size);
    copy(i);
  }
  for (size_t i = num_ahead; i < members.size(); ++i) {
    copy(i);
  }
}

}  // namespace

void GatherRows(std::span<const uint8_t> rows, size_t row_size, std::span<const uint32_t> members,
                uint8_t* to) {
  // The default size of codes; a constant lets a copy be a single move.
  constexpr std::integral_constant<size_t, 8> kUsualSize;
  if (row_size == kUsualSize) {
    Gather(rows.data(), kUsualSize, members, to);
  } else {
    Gather(rows.data(), row_size, members, to);
  }
}

LargeVector<uint8_t> OrderCodes(std::span<const uint8_t> codes, size_t code_size,
                                const TileLists& lists) {
  LargeVector<uint8_t> ordered(codes.size());
  if (lists.empty()) {
    std::copy(codes.begin(), codes.end(), ordered.begin());
  }
  GatherRows(codes, code_size, lists.members, ordered.data());
  return ordered;
}

}  // namespace cairn
