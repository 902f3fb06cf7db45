#include "storage/map/internal/layer_extent.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "storage/map/map_store.h"
#include "support/map_builder.h"
#include "support/places.h"
#include "support/raw_sql.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::IsEmpty;

// Places come and go, at the edges of the map and within; the check compares the extents.
TEST(LayerExtent, FollowsWhatUpdatesAddAndRemove) {
  const testing::TempDir dir;
  MapStore store = MapStore::Create(dir.File("a.gpkg"));
  std::mt19937 random(5);
  for (int step = 0; step < 40; ++step) {
    MapUpdate update = store.BeginUpdate();
    for (int i = 0; i < 3; ++i) {
      const int place = static_cast<int>(random() % 9);
      if (random() % 2 == 0) {
        testing::PutPlace(place, random(), &update, 5);
      } else {
        testing::RemovePlace(place, &update);
      }
    }
    update.Publish();
    ASSERT_THAT(store.Check({}).problems, IsEmpty()) << "step " << step;
  }
}

TEST(LayerExtent, IsMadeAnewIfItIsMissing) {
  const testing::TempDir dir;
  MapStore store = MapStore::Create(dir.File("a.gpkg"));
  for (const int place : {0, 1}) {
    testing::ExecuteRaw(store.path(), "UPDATE gpkg_contents SET min_x = NULL, max_y = NULL");
    MapUpdate update = store.BeginUpdate();
    testing::PutPlace(place, 1, &update);
    update.Publish();
  }
  EXPECT_THAT(store.Check({}).problems, IsEmpty());
}

}  // namespace
}  // namespace cairn
