#include "storage/tile/tile_lists.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

namespace cairn {
namespace {

// Codes of any size, and more or fewer of them than are asked for ahead.
TEST(OrderCodes, PutsEachMemberInItsPlace) {
  std::mt19937 random(1);
  for (const size_t code_size : {1, 8, 16, 20}) {
    for (const uint32_t count : {0, 1, 15, 16, 17, 500}) {
      std::vector<uint8_t> codes(count * code_size);
      std::generate(codes.begin(), codes.end(), [&] { return static_cast<uint8_t>(random()); });
      TileLists lists;
      lists.begin = {0, count};
      lists.members.resize(count);
      std::iota(lists.members.begin(), lists.members.end(), 0);
      std::shuffle(lists.members.begin(), lists.members.end(), random);
      const LargeVector<uint8_t> ordered = OrderCodes(codes, code_size, lists);
      ASSERT_EQ(ordered.size(), codes.size());
      for (size_t i = 0; i < ordered.size(); ++i) {
        ASSERT_EQ(ordered[i], codes[lists.members[i / code_size] * code_size + i % code_size]);
      }
    }
  }
}

TEST(OrderCodes, LeavesThemAsTheyAreWithoutLists) {
  const std::vector<uint8_t> codes = {5, 6, 7, 8};
  const LargeVector<uint8_t> ordered = OrderCodes(codes, 2, {});
  EXPECT_EQ(std::vector<uint8_t>(ordered.begin(), ordered.end()), codes);
}

}  // namespace
}  // namespace cairn
