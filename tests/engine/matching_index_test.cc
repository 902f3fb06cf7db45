#include "engine/index/matching_index.h"

#include "engine/matching_index_suite.h"

namespace cairn {
namespace {

TEST(MakeTileLists, HoldEveryDescriptorOnceAndNoListIsEmpty) {
  const SyntheticDescriptors data = MakeSyntheticDescriptors({.num_landmarks = 50});
  const TileLists lists =
      MakeTileLists(*data.codebook, data.codes, {.num_lists = 100, .num_iterations = 20});
  LargeVector<uint32_t> members = lists.members;
  std::sort(members.begin(), members.end());
  LargeVector<uint32_t> all(100);
  std::iota(all.begin(), all.end(), 0u);
  EXPECT_EQ(members, all);
  EXPECT_EQ(lists.begin.front(), 0u);
  EXPECT_EQ(lists.begin.back(), 100u);
  EXPECT_TRUE(std::is_sorted(lists.begin.begin(), lists.begin.end(), std::less_equal<>()));
  EXPECT_TRUE(MakeTileLists(*data.codebook, {}, {}).empty());
}

INSTANTIATE_TEST_SUITE_P(AllKinds, MatchingIndexTest, ::testing::ValuesIn(testing::EngineIndices()),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace cairn
