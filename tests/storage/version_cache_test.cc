#include "storage/map/internal/version_cache.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cairn {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

FoundTile SomeTile() { return std::make_shared<BoundedTile>(); }

TEST(VersionCache, TellsTilesFromEmptySquaresAndFromUnknownOnes) {
  VersionCache cache(MapVersion(1));
  const FoundTile tile = SomeTile();
  cache.Keep({{1, tile}, {2, nullptr}});
  const FoundTiles found = cache.Find({1, 2, 3});
  EXPECT_THAT(found.tiles, ElementsAre(tile));
  EXPECT_THAT(found.missing_ids, ElementsAre(3));
}

TEST(VersionCache, KeepsWhatCameLastWhenItIsFull) {
  VersionCache cache(MapVersion(1));
  std::unordered_map<int64_t, FoundTile> many;
  for (size_t i = 0; i < VersionCache::kMaxTiles; ++i) {
    many[static_cast<int64_t>(i)] = nullptr;
  }
  cache.Keep(many);
  EXPECT_THAT(cache.Find({0}).missing_ids, IsEmpty());
  cache.Keep({{-1, SomeTile()}, {-2, nullptr}});
  EXPECT_THAT(cache.Find({-2, -1}).missing_ids, IsEmpty());
  EXPECT_THAT(cache.Find({0}).missing_ids, ElementsAre(0));
}

}  // namespace
}  // namespace cairn
