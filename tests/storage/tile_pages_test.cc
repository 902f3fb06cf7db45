// Tests the listing of tiles page by page.
#include "storage/map/internal/tile_pages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "core/angles.h"
#include "storage/map/map_store.h"
#include "support/map_builder.h"
#include "support/map_place.h"
#include "support/temp_dir.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

using testing::AddTile;
using testing::BoxDeg;
using testing::Ids;
using ::testing::IsEmpty;
using testing::RandomCodebook;
using testing::RandomTile;
using testing::TempDir;
using testing::TileAt;

const GeoBox kWorld = BoxDeg(-90, -180, 90, 180);

// Adds about `side` x `side` neighboring tiles.
void AddSquareOfTiles(int side, MapStore* store) {
  MapUpdate update = store->BeginUpdate();
  update.AddCodebook(RandomCodebook());
  const Tile tile = RandomTile({.id = TileAt(49.0, 8.4), .num_landmarks = 1, .num_keyframes = 0});
  std::vector<TileId> ids;
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      ids.push_back(TileAt(49.0 + row * 0.00135, 8.4 + column * 0.00206));
    }
  }
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  for (const TileId id : ids) {
    Tile copy = tile;
    copy.id = id;
    AddTile(copy, &update);
  }
  update.Publish();
}

struct Pages {
  std::vector<TileId> ids;  // Of all pages.
  int count = 0;
};

// Reads pages until there are no more.
Pages ReadPages(const MapSnapshot& snapshot, std::optional<GeoBox> box, int64_t limit) {
  Pages pages;
  TilePageRequest request{.box = box, .after = {}, .limit = limit};
  do {
    const TilePage page = snapshot.FindTilePage(request);
    EXPECT_LE(static_cast<int64_t>(page.tiles.size()), limit);
    for (const TileId id : Ids(page.tiles)) {
      pages.ids.push_back(id);
    }
    request.after = page.resume_after;
    ++pages.count;
  } while (request.after && pages.count < 10'000);
  return pages;
}

class TilePages : public testing::MapPlaceTest {};
CAIRN_ON_BOTH_KINDS_OF_MAPS(TilePages);

TEST_P(TilePages, HaveEachTileOnce) {
  MapStore store = MapStore::Create(Place("a"));
  AddSquareOfTiles(6, &store);
  const MapSnapshot snapshot = store.Snapshot();
  const std::vector<TileId> all = Ids(snapshot.AllTiles(1000));
  ASSERT_GT(all.size(), 20u);
  const GeoBox some = BoxDeg(49.002, 8.4, 49.004, 8.408);
  ASSERT_THAT(Ids(snapshot.FindTiles(some)), ::testing::Not(IsEmpty()));
  for (const int64_t limit : {1, 7, 1000}) {
    EXPECT_EQ(ReadPages(snapshot, std::nullopt, limit).ids, all);
    EXPECT_EQ(ReadPages(snapshot, kWorld, limit).ids, all);
    EXPECT_EQ(ReadPages(snapshot, some, limit).ids, Ids(snapshot.FindTiles(some)));
  }
  EXPECT_THAT(ReadPages(snapshot, BoxDeg(10, 8, 20, 9), 7).ids, IsEmpty());
  EXPECT_EQ(ReadPages(snapshot, std::nullopt, 1000).count, 1);
}

TEST_P(TilePages, CrossTheAntimeridian) {
  MapStore store = MapStore::Create(Place("a"));
  MapUpdate update = store.BeginUpdate();
  update.AddCodebook(RandomCodebook());
  for (const double lon_deg : {179.9995, -179.9995, 170.0}) {
    AddTile(RandomTile({.id = TileAt(-17.0, lon_deg), .num_landmarks = 1, .num_keyframes = 0}),
            &update);
  }
  update.Publish();
  const GeoBox box = BoxDeg(-18, 179, -16, -179);
  EXPECT_THAT(ReadPages(store.Snapshot(), box, 1).ids,
              ::testing::UnorderedElementsAre(TileAt(-17.0, 179.9995), TileAt(-17.0, -179.9995)));
}

TEST_P(TilePages, ShowTheVersionOfTheSnapshot) {
  MapStore store = MapStore::Create(Place("a"));
  AddSquareOfTiles(3, &store);
  const MapSnapshot before = store.Snapshot();
  const std::vector<TileId> all = Ids(before.AllTiles(1000));
  MapUpdate update = store.BeginUpdate();
  update.RemoveTile(all[1]);
  update.RemoveTile(all[4]);
  update.Publish();
  for (const int64_t limit : {1, 2, 3, 1000}) {
    EXPECT_EQ(ReadPages(before, std::nullopt, limit).ids, all) << limit;
    EXPECT_EQ(ReadPages(before, kWorld, limit).ids, all) << limit;
    EXPECT_EQ(ReadPages(store.Snapshot(), kWorld, limit).ids.size(), all.size() - 2) << limit;
  }
}

// With more tiles in the box than one page may look at.
TEST(LargeTilePages, GoThroughABoxOfManyTiles) {
  const TempDir dir;
  MapStore store = MapStore::Create(dir.File("a.gpkg"));
  AddSquareOfTiles(76, &store);
  const MapSnapshot snapshot = store.Snapshot();
  const std::vector<TileId> all = Ids(snapshot.AllTiles(100'000));
  ASSERT_GT(all.size(), 5500u);
  EXPECT_EQ(snapshot.FindTilePage({.box = kWorld, .after = {}, .limit = 1}).tiles.size(), 1u);
  const Pages pages = ReadPages(snapshot, kWorld, 3000);
  EXPECT_EQ(pages.ids, all);
  EXPECT_EQ(pages.count, 2);
  // The first tiles by id are in the west, outside of the box.
  const GeoBox east = BoxDeg(48, 8.405, 50, 9);
  EXPECT_EQ(ReadPages(snapshot, east, 3000).ids, Ids(snapshot.FindTiles(east)));
}

}  // namespace
}  // namespace cairn
