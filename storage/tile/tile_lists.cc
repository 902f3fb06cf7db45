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

LargeVector<uint8_t> OrderCodes(std::span<const uint8_t> codes, size_t code_size,
                                const TileLists& lists) {
  LargeVector<uint8_t> ordered(codes.size());
  if (lists.empty()) {
    std::copy(codes.begin(), codes.end(), ordered.begin());
  }
  if (code_size == 8) {  // The default size; a constant lets a copy be a single move.
    Gather(codes.data(), std::integral_constant<size_t, 8>(), lists.members, ordered.data());
  } else {
    Gather(codes.data(), code_size, lists.members, ordered.data());
  }
  return ordered;
}

}  // namespace cairn
