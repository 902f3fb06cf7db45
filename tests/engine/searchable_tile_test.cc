#include "engine/tiles/searchable_tile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/error.h"
#include "engine/simple_tile.h"

namespace cairn {
namespace {

using testing::SimpleTile;
using testing::SimpleView;

TEST(SearchableTile, RefusesACodebookThatIsNotTheTiles) {
  EXPECT_THROW(
      SearchableTile(SimpleTile({}), testing::LatticeCodebook(CodebookId{2}), IndexOptions()),
      Error);
  Tile tile = SimpleTile({});
  tile.code_size = 8;
  EXPECT_THROW(SearchableTile(tile, testing::LatticeCodebook(), IndexOptions()), Error);
}

TEST(SearchableTile, KnowsTheLandmarkOfEachDescriptorAndItsSize) {
  const Tile tile = SimpleTile({{1, {{0.1f}, {0.2f}}}, {2, {{0.3f}}}});
  const TileView view = SimpleView(tile);
  const DescriptorPlaces& places = view.tile->places();
  ASSERT_EQ(places.size(), 3u);
  for (const auto& [descriptor, landmark] :
       {std::pair(0u, 0u), std::pair(1u, 0u), std::pair(2u, 1u)}) {
    const auto order = view.tile->index().order();
    const size_t place = order.empty()
                             ? descriptor
                             : std::find(order.begin(), order.end(), descriptor) - order.begin();
    EXPECT_EQ(places.descriptor(place), descriptor);
    EXPECT_EQ(places.landmark(place), landmark);
  }
  EXPECT_GT(view.tile->MemoryBytes(), tile.MemoryBytes() + view.tile->index().MemoryBytes());
}

}  // namespace
}  // namespace cairn
